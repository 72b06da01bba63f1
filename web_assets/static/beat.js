// Heartbeat of the live page, on its own thread, because browsers slow the timers of hidden pages. While the page
// is looked at, it must have spoken within the last 0.7 s and its picture must be fresh; else this falls silent and
// the server holds the movement. Closing the page ends this thread, which holds it too.
"use strict";
let told = null;
let heardAt = -1e9;
let waiting = false;

onmessage = (event) => {
  told = event.data;
  if (told.alive) heardAt = performance.now();
};

async function beat() {
  if (told === null || waiting) return;
  const alive = told.hidden || performance.now() - heardAt < 700;
  const asked = performance.now();
  waiting = true;
  try {
    const answer = await fetch("/live/beat", {
      method: "POST",
      headers: { Accept: "application/json", "X-Form-Token": told.token },
      body: new URLSearchParams({ page: alive ? told.page : "" }),
      signal: AbortSignal.timeout(2000),
    });
    const said = await answer.json();
    postMessage({ status: answer.status, said, took: performance.now() - asked });
  } catch (problem) {
    postMessage({ status: 0, said: {} });
  } finally {
    waiting = false;
  }
}
setInterval(beat, 200);
