// The live page: sends what the person asks for, shows what the server says. The server decides everything.
"use strict";
const page = [...crypto.getRandomValues(new Uint8Array(16))].map((b) => b.toString(16).padStart(2, "0")).join("");
const token = document.body.dataset.token;
const main = document.getElementById("main");
const said = document.getElementById("said");
const frame = document.querySelector("iframe[data-viewport]");
const stale = document.getElementById("stale");
const byId = (name) => document.getElementById(name);
const all = (query) => [...document.querySelectorAll(query)];
let now = { state: "idle", frame: 0 };
let answeredAt = performance.now();
let refusedUntil = 0;
let knownTake = "";
let heldSpeed = false;

// --- what the person asks for

async function ask(path, fields) {
  const answer = await fetch(path, {
    method: "POST",
    headers: { Accept: "application/json", "X-Form-Token": token },
    body: new URLSearchParams({ ...fields, page }),
  });
  const text = await answer.json().catch(() => ({ message: "The server gave no answer." }));
  if (answer.status === 401) return void location.assign("/sign-in?next=/live");
  if (!answer.ok) {
    refusedUntil = performance.now() + 8000;
    say("⚠ " + text.message, "bad");
  } else {
    refusedUntil = 0;
  }
  return answer.ok;
}

for (const form of all("form[data-verb]")) {
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    ask("/live/" + form.dataset.verb, Object.fromEntries(new FormData(form)));
  });
}
for (const button of all("[data-do]")) {
  button.addEventListener("click", async () => {
    if (button.dataset.do !== "approve") return void ask("/live/" + button.dataset.do, {});
    if (await ask("/takes/" + now.take + "/approve", { back: "live" })) await listTakes(now.take);
  });
}
byId("speed").addEventListener("pointerdown", () => { heldSpeed = true; });
byId("speed").addEventListener("input", (event) => { byId("speed-out").textContent = event.target.value + " %"; });
byId("speed").addEventListener("change", async (event) => {
  await ask("/live/speed", { speed: event.target.value });
  heldSpeed = false;
});

// --- tabs

const tabs = all("[role=tab]");
function choose(tab) {
  for (const other of tabs) {
    const chosen = other === tab;
    other.setAttribute("aria-selected", String(chosen));
    other.tabIndex = chosen ? 0 : -1;
    byId(other.getAttribute("aria-controls")).hidden = !chosen;
  }
}
for (const tab of tabs) {
  tab.addEventListener("click", () => choose(tab));
  tab.addEventListener("keydown", (event) => {
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    const other = tabs.find((item) => item !== tab);
    choose(other);
    other.focus();
  });
}
if (location.hash === "#record") choose(byId("tab-record"));
byId("desk-toggle").addEventListener("click", () => {
  const open = document.body.classList.toggle("desk-closed");
  byId("desk-toggle").setAttribute("aria-expanded", String(!open));
});

// --- what the server says

function say(text, kind) {
  if (said.textContent !== text) said.textContent = text;
  said.className = kind;
}

function fill(name, text) {
  for (const place of all(`[data-show="${name}"]`)) if (place.textContent !== text) place.textContent = text;
}

function figure(name, text) {
  const box = document.querySelector(`[data-when="${name}"]`);
  box.hidden = text === "";
  fill(name, text);
}

function showPatient() {
  const chosen = document.querySelector("select[name=patient]").selectedOptions[0];
  const them = now.busy || now.state === "stopped" ? now.patient : null;
  const recording = ["countdown", "recording", "processing"].includes(now.state);
  if (recording) {
    fill("name", "Recording a demonstration"); fill("born", ""); fill("side", now.side.toUpperCase() + " hand");
  } else if (them) {
    fill("name", them.name); fill("born", "born " + them.born); fill("side", them.side.toUpperCase() + " hand");
  } else if (chosen && chosen.value) {
    fill("name", chosen.dataset.name); fill("born", chosen.dataset.born);
    fill("side", chosen.dataset.side.toUpperCase() + " hand");
  } else {
    fill("name", "No patient chosen"); fill("born", ""); fill("side", "");
  }
}

const SIGNS = { idle: "○", countdown: "◔", recording: "●", processing: "…", rehearsing: "…", playing: "▶", stopped: "■", done: "✓", failed: "⚠" };
const KINDS = { playing: "ready", done: "ready", stopped: "alarm", failed: "caution", recording: "ready" };

function show(state) {
  now = state;
  main.dataset.state = now.state;
  main.dataset.frame = String(now.frame);
  main.dataset.held = String(now.paused);
  main.dataset.operator = String(now.operator);
  const word = byId("state-word");
  word.textContent = (now.paused ? "❚❚" : SIGNS[now.state]) + " " + now.word;
  word.className = "chip " + (now.paused ? "caution" : KINDS[now.state] ?? "");
  const playing = now.state === "playing";
  figure("phase", playing ? now.phase : "");
  figure("repetition", playing && now.repetition > 0 ? `${now.repetition} of ${now.repetitions}` : "");
  figure("tracking", now.state === "recording" && now.tracking_percent !== null ? `${now.tracking_percent} %` : "");
  showQuality();
  showPatient();
  if (performance.now() > refusedUntil) say(now.message, now.state === "failed" ? "bad" : now.paused ? "caution" : "");
  showDesk();
  if (now.state === "done" && now.take && !now.session && now.take !== knownTake) listTakes("");
}

function showQuality() {
  const estimated = now.estimated_percent ?? 0;
  const lost = now.lost_percent ?? 0;
  // while the hand is still learnt, blobs are seen that have no name yet: neither measured nor lost
  const unnamed = lost === 100 && now.tracking_percent > 0;
  const known = now.tracking_percent !== null && !unnamed;
  const shares = { measured: known ? Math.max(0, 100 - estimated - lost) : 0, estimated: known ? estimated : 0, lost: known ? lost : 0 };
  for (const [name, share] of Object.entries(shares)) {
    document.querySelector(`[data-share=${name}]`).style.width = share + "%";
    fill(name, known ? share + " %" : "–");
  }
  fill("dropped", now.dropped ? `, ${now.dropped} captures lost` : "");
  byId("quality").setAttribute("aria-label", known ? `Markers in the last second: ${shares.measured} % measured, ${estimated} % estimated, ${lost} % lost` : "Markers: not named yet");
}

function showDesk() {
  byId("idle-desk").hidden = now.busy || now.state === "stopped";
  byId("busy-desk").hidden = !now.busy;
  for (const part of all("#busy-desk [data-in]")) {
    const right = part.dataset.paused === undefined || (part.dataset.paused === "yes") === now.paused;
    part.hidden = !part.dataset.in.split(" ").includes(now.state) || !right;
  }
  if (main.dataset.mayPlay === "no") for (const part of all("#busy-desk button:not([data-do=pain]), #speed")) part.disabled = true;
  byId("countdown").hidden = now.state !== "countdown";
  byId("countdown").firstElementChild.textContent = String(Math.ceil(now.countdown_s));
  if (!heldSpeed && now.speed_percent) {
    byId("speed").value = String(now.speed_percent);
    byId("speed-out").textContent = now.speed_percent + " %";
  }
  const ended = now.state === "done" || now.state === "stopped";
  byId("after").hidden = !(ended && (now.take || now.session));
  for (const part of all("[data-after=take]")) part.hidden = Boolean(now.session) || !now.take;
  for (const part of all("[data-after=session]")) part.hidden = !now.session;
  fill("take", now.take); fill("session", now.session);
  link("take", "/takes/" + now.take);
  link("session", "/sessions/" + now.session);
  link("report", "/sessions/" + now.session + "/report");
}

function link(name, path) {
  for (const place of all(`[data-link="${name}"]`)) place.setAttribute("href", path);
}

async function listTakes(chosen) {
  knownTake = now.take;
  const answer = await fetch("/live/takes", { headers: { Accept: "application/json" } });
  if (!answer.ok) return;
  const list = document.querySelector("select[name=take]");
  const kept = chosen || list.value;
  const rows = await answer.json();
  const approve = document.querySelector("[data-do=approve]");
  const mine = rows.find((row) => row.id === now.take);
  if (approve && mine) {
    approve.disabled = Boolean(mine.approved_by);
    approve.textContent = mine.approved_by ? "✓ Approved" : "✓ Approve";
  }
  const options = rows.filter((row) => row.approved_by).map((row) => {
    const words = `${row.words}, ${row.side}, ${row.seconds.toFixed(1)} s (${row.id.slice(0, 8)})`;
    return new Option(words, row.id, false, row.id === kept);
  });
  if (options.length) list.replaceChildren(...options);
  if (chosen) choose(byId("tab-play"));
}
document.querySelector("select[name=patient]").addEventListener("change", showPatient);

// --- cameras: asked for when the list is about to be used, because looking for devices takes a moment

const cameraList = document.querySelector("select[name=camera]");
let cameras = [];

async function listCameras() {
  const answer = await fetch("/live/cameras", { headers: { Accept: "application/json" } });
  if (!answer.ok) return;
  cameras = await answer.json();
  const kept = cameraList.value;
  cameraList.replaceChildren(...cameras.map((one) => {
    const option = new Option(one.ready ? one.words : `${one.words} (${one.state})`, one.id, false, one.id === kept);
    option.disabled = !one.ready;
    return option;
  }));
  hintCamera();
}

function hintCamera() {
  const one = cameras.find((item) => item.id === cameraList.value);
  const needs = cameras.filter((item) => !item.ready && item.remedy).map((item) => `${item.words}: ${item.remedy}`);
  const depth = one && !one.has_depth ? "No depth: places in space rest on the size of the hand alone. " : "";
  const virtual = cameraList.value === "virtual" ? "It renders a hand with markers. " : depth;
  byId("camera-hint").textContent = virtual + needs.join(" ");
}
cameraList.addEventListener("change", hintCamera);
byId("tab-record").addEventListener("click", listCameras);
if (location.hash === "#record") listCameras();

// --- freshness: the picture carries the number of the frame that it shows

let shownFrame = "";
let shownChangedAt = performance.now();
let sentFrame = -1;
let sentChangedAt = performance.now();

function lag() {
  const mark = frame.contentDocument?.querySelector("[data-frame]");
  const clock = performance.now();
  if (mark && mark.dataset.frame !== shownFrame) { shownFrame = mark.dataset.frame; shownChangedAt = clock; }
  if (now.frame !== sentFrame) { sentFrame = now.frame; sentChangedAt = clock; }
  const moving = now.state === "playing" && !now.paused && clock - sentChangedAt < 500;
  if (clock - answeredAt > 1000) return clock - answeredAt;
  return moving ? clock - shownChangedAt : 0; // a picture that never came is as old as this page
}

function tick() {
  const late = lag();
  const lost = performance.now() - answeredAt > 1000;
  stale.hidden = late < 300;
  stale.firstElementChild.textContent = (lost ? "NO CONNECTION" : "STALE") + ": this picture is old";
  beat.postMessage({ token, page, alive: late < 1000, hidden: document.hidden });
}

const beat = new Worker("/static/beat.js");
beat.onmessage = (event) => {
  const { status, said: state } = event.data;
  if (status === 401) return void location.assign("/sign-in?next=/live");
  if (status !== 200) return;
  answeredAt = performance.now();
  show(state);
};
document.addEventListener("visibilitychange", tick);
setInterval(tick, 150);
tick();
