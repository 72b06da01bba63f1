// The patient's screen: asks once a second what comes next; pain by one tap.
"use strict";
(() => {
  const byId = (name) => document.getElementById(name);
  const title = byId("mine-exercise").textContent;

  function show(now) {
    byId("mine-hello").hidden = !now.name;
    byId("mine-name").textContent = now.name;
    byId("mine-exercise").textContent = now.exercise || title;
    byId("mine-count").textContent = now.count;
    if (byId("mine-step").textContent !== now.step) byId("mine-step").textContent = now.step;
  }
  async function ask() {
    try {
      const answer = await fetch("/mine/state", { headers: { Accept: "application/json" } });
      if (answer.status === 401) location.assign("/sign-in?next=/mine");
      if (answer.ok) show(await answer.json());
    } catch (problem) { /* the stop's own watch says that the server is gone */ }
  }
  byId("mine-pain").addEventListener("submit", async (event) => {
    event.preventDefault();
    try {
      const answer = await fetch("/live/pain", {
        method: "POST", headers: { Accept: "application/json", "X-Form-Token": document.body.dataset.token },
        body: new URLSearchParams(),
      });
      byId("mine-said").textContent = (await answer.json()).message;
    } catch (problem) {
      byId("stop").classList.add("failed");
    }
  });
  setInterval(ask, 1000);
})();
