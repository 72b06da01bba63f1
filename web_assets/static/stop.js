// The emergency stop on every page: one click or the key Escape, also from inside the pictures.
"use strict";
(() => {
  const form = document.getElementById("stop");
  const button = document.getElementById("stop-button");
  const latched = document.getElementById("latched");

  function show(stopped) {
    latched.hidden = !stopped;
    document.body.dataset.stopped = stopped ? "yes" : "no";
    document.dispatchEvent(new CustomEvent("stop-state", { detail: stopped }));
  }

  async function press() {
    button.classList.add("pressed");
    try {
      const answer = await fetch("/stop", {
        method: "POST", keepalive: true, credentials: "same-origin", headers: { Accept: "application/json" },
      });
      if (!answer.ok) throw new Error(String(answer.status));
      form.classList.remove("failed");
      show(true);
    } catch (problem) {
      form.classList.add("failed");
      button.title = form.dataset.failed;
    } finally {
      button.classList.remove("pressed");
    }
  }

  function onKey(event) {
    if (event.key !== "Escape" || event.repeat) return;
    press();
  }

  // A finger stops as it goes down; the click that follows it is the same press.
  let pointerAt = -1e9;
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    pointerAt = performance.now();
    press();
  });
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    if (performance.now() - pointerAt > 1000) press();
  });
  document.addEventListener("keydown", onKey, true);
  for (const frame of document.querySelectorAll("iframe[data-viewport]")) {
    const listen = () => {
      if (frame.contentDocument) frame.contentDocument.addEventListener("keydown", onKey, true);
    };
    frame.addEventListener("load", listen);
    listen();
  }

  async function ask() {
    try {
      const answer = await fetch("/stop/state", { headers: { Accept: "application/json" } });
      show((await answer.json()).stopped);
      form.classList.remove("failed");
    } catch (problem) {
      form.classList.add("failed");
    }
  }
  setInterval(ask, 1000);

  const notice = document.querySelector(".full .notice[role=status]");
  if (notice) setTimeout(() => notice.remove(), 6000);
})();
