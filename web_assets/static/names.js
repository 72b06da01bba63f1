// Names for markers: a click on a ring gives it the chosen name, then the next name is chosen.
"use strict";
(() => {
  const room = document.getElementById("naming");
  if (!room) return;
  const WORDS = JSON.parse(document.getElementById("words").textContent);
  const told = (key, values) => WORDS[key].replace(/\{(\w+)\}/g, (_, name) => values[name]);
  const svg = document.getElementById("first-picture");
  const blobs = [...svg.querySelectorAll(".blob")];
  const buttons = [...document.querySelectorAll("#marker-list button")];
  const names = buttons.map((button) => button.dataset.name);
  const hint = document.getElementById("hint");
  const count = document.getElementById("count");
  const undo = document.getElementById("undo");
  const again = document.getElementById("again");
  const refusal = document.getElementById("refusal");
  const fewest = Number(room.dataset.fewest);
  let placed = new Map(); // name to index of its ring
  let chosen = names[0];
  let busy = false;
  const past = [];

  function nameOf(blob) {
    for (const [name, at] of placed) if (at === blob) return name;
    return "";
  }

  function remember() {
    past.push([new Map(placed), chosen]);
  }

  function place(blob) {
    if (busy) return;
    if (!chosen) return show(WORDS.placed);
    remember();
    const before = nameOf(blob);
    if (before) placed.delete(before);
    placed.set(chosen, blob);
    const start = names.indexOf(chosen);
    const order = [...names.slice(start + 1), ...names.slice(0, start + 1)];
    chosen = order.find((name) => !placed.has(name)) ?? "";
    show();
  }

  function back() {
    if (busy || !past.length) return;
    [placed, chosen] = past.pop();
    show();
  }

  function show(sentence) {
    blobs.forEach((blob, index) => {
      const name = nameOf(index);
      blob.classList.toggle("named", Boolean(name));
      blob.querySelector("text").textContent = name ? String(names.indexOf(name) + 1) : "";
      blob.setAttribute("aria-label", told("ring", { n: index + 1, m: blobs.length, name: name || WORDS.unnamed }));
    });
    buttons.forEach((button) => {
      const name = button.dataset.name;
      button.setAttribute("aria-pressed", String(name === chosen));
      button.classList.toggle("named", placed.has(name));
      button.querySelector("i").textContent = placed.has(name) ? "✓" : "";
    });
    const left = fewest - placed.size;
    hint.textContent = sentence ?? (chosen ? told("click", { name: chosen }) : WORDS.ready);
    count.textContent = told("count", { n: placed.size, m: names.length }) + (left > 0 ? "; " + told("more", { n: left }) : ".");
    undo.disabled = busy || !past.length;
    again.disabled = busy || left > 0;
    buttons.forEach((button) => { button.disabled = busy; });
  }

  function nearest(event) {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const far = blobs.map((blob) => Math.hypot(blob.dataset.u - at.x, blob.dataset.v - at.y));
    const best = far.indexOf(Math.min(...far));
    return far[best] <= Number(room.dataset.reach) ? best : -1;
  }

  function focusOn(index) {
    blobs.forEach((blob, other) => blob.setAttribute("tabindex", other === index ? "0" : "-1"));
    blobs[index].focus({ preventScroll: true });
  }

  const WAYS = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] };

  function towards(from, [x, y]) {
    let best = -1, least = Infinity;
    blobs.forEach((blob, index) => {
      const dx = blob.dataset.u - blobs[from].dataset.u, dy = blob.dataset.v - blobs[from].dataset.v;
      const along = dx * x + dy * y, across = Math.abs(dx * y - dy * x);
      const cost = along + 2 * across;
      if (along > 1 && cost < least) [best, least] = [index, cost];
    });
    return best;
  }

  svg.addEventListener("click", (event) => {
    const blob = nearest(event);
    if (blob < 0) return show(told("noRing", { name: chosen }));
    focusOn(blob);
    place(blob);
  });
  svg.addEventListener("keydown", (event) => {
    const index = blobs.indexOf(event.target);
    if (index < 0) return;
    if (event.key === "Enter" || event.key === " ") place(index);
    else if (event.key in WAYS) {
      const next = towards(index, WAYS[event.key]);
      if (next >= 0) focusOn(next);
    } else return;
    event.preventDefault();
  });
  buttons.forEach((button) => button.addEventListener("click", () => {
    chosen = button.dataset.name;
    show();
  }));
  undo.addEventListener("click", back);
  document.addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z") {
      event.preventDefault();
      back();
    }
  });

  async function trackAgain() {
    const labels = [...placed].map(([name, at]) => `${name}=${blobs[at].dataset.u},${blobs[at].dataset.v}`);
    busy = true;
    refusal.hidden = true;
    const start = performance.now();
    const tell = () => show(told("tracking", { n: Math.round((performance.now() - start) / 1000) }));
    tell();
    const clock = setInterval(tell, 1000);
    let said = WORDS.noAnswer;
    try {
      const answer = await fetch(room.dataset.action, {
        method: "POST",
        headers: { Accept: "application/json", "X-Form-Token": document.body.dataset.token },
        body: new URLSearchParams({ labels: labels.join(" ") }),
      });
      const content = await answer.json();
      if (answer.ok) {
        location.assign(content.path);
        return;
      }
      said = content.message;
    } catch (problem) { /* the sentence above says it */ } finally { clearInterval(clock); }
    busy = false;
    show();
    refusal.textContent = said;
    refusal.hidden = false;
  }
  again.addEventListener("click", trackAgain);
  window.addEventListener("beforeunload", (event) => {
    if (placed.size && !busy) event.preventDefault();
  });
  show();
})();
