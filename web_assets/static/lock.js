// Covers the page when nobody used it for a while, and asks for the password of the same person again.
// Everything on the page stays as it is, the stop stays in reach, and whatever moves is not touched.
"use strict";
(() => {
  const cover = document.getElementById("cover");
  const form = document.getElementById("unlock");
  const problem = document.getElementById("unlock-problem");
  const idleMs = 1000 * Number(document.body.dataset.idleS);
  const beneath = [...document.body.children].filter((part) => part !== cover && part.id !== "stop" && part.tagName !== "SCRIPT");
  let usedAt = performance.now();
  let toldAt = performance.now();
  let askedAt = 0;

  function show(locked) {
    if (locked === !cover.hidden) return;
    cover.hidden = !locked;
    for (const part of beneath) part.inert = locked;
    if (locked) form.elements.password.focus();
    else { form.elements.password.value = ""; problem.hidden = true; usedAt = toldAt = performance.now(); }
  }
  function takeToken(token) {
    if (!token || token === document.body.dataset.token) return;
    document.body.dataset.token = token;
    for (const field of document.querySelectorAll("input[name=form_token]")) field.value = token;
  }
  function used() {
    if (!cover.hidden) return;
    usedAt = performance.now();
    if (usedAt - toldAt < 60000 && usedAt - toldAt < idleMs / 3) return;
    toldAt = usedAt;
    fetch("/here", { method: "POST", headers: { Accept: "application/json", "X-Form-Token": document.body.dataset.token } })
      .then((answer) => { if (answer.status === 423 || answer.status === 401) show(true); }, () => {});
  }
  for (const kind of ["pointerdown", "keydown", "input", "wheel"]) {
    document.addEventListener(kind, used, { capture: true, passive: true });
  }

  // Another tab of this browser may be in use: the server knows.
  async function look() {
    const now = performance.now();
    const covered = !cover.hidden;
    if (now - askedAt < 5000 || (!covered && now - usedAt < idleMs)) return;
    askedAt = now;
    try {
      const said = await (await fetch("/here", { headers: { Accept: "application/json" } })).json();
      if (said.state === "open") {
        usedAt = now - 1000 * said.idle_s;
        show(false);
      } else {
        show(true);
      }
    } catch (failed) { show(true); }
  }
  setInterval(look, 1000);
  document.addEventListener("visibilitychange", look);
  document.addEventListener("sign-in-ended", () => show(true)); // a script was answered so: what is typed stays

  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    problem.hidden = true;
    try {
      const answer = await fetch("/unlock", {
        method: "POST", headers: { Accept: "application/json" }, body: new URLSearchParams(new FormData(form)),
      });
      const said = await answer.json();
      if (!answer.ok) throw new Error(said.message);
      takeToken(said.token);
      show(false);
    } catch (failed) {
      problem.textContent = "\u26a0 " + failed.message;
      problem.hidden = false;
      form.elements.password.select();
    }
  });
})();
