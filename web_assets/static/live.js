// The live page: sends what the person asks for, shows what the server says. The server decides everything.
"use strict";
const page = [...crypto.getRandomValues(new Uint8Array(16))].map((b) => b.toString(16).padStart(2, "0")).join("");
const main = document.getElementById("main");
const said = document.getElementById("said");
const frame = document.querySelector("iframe[data-viewport]");
const stale = document.getElementById("stale");
const byId = (name) => document.getElementById(name);
const WORDS = JSON.parse(byId("words").textContent); // what this script says, in the language of the page
const told = (key, values) => WORDS[key].replace(/\{(\w+)\}/g, (_, name) => values[name]);
const handOf = (side) => WORDS[side] ?? side;
const all = (query) => [...document.querySelectorAll(query)];
let now = { state: "idle", frame: 0 };
let knownAt = performance.now(); // what the server said last is at least as new as this: when it was asked
let refusedUntil = 0;
let knownTake = "";
let heldSpeed = false;

// --- what the person asks for

// The page is covered and asks for the password: a note that is being written stays where it is.
function signInEnded() {
  if (byId("cover")) document.dispatchEvent(new Event("sign-in-ended"));
  else location.assign("/sign-in?next=/live");
}

async function ask(path, fields) {
  const answer = await fetch(path, {
    method: "POST",
    headers: { Accept: "application/json", "X-Form-Token": document.body.dataset.token },
    body: new URLSearchParams({ ...fields, page }),
  });
  const text = await answer.json().catch(() => ({ message: WORDS.noAnswer }));
  if (answer.status === 401) return void signInEnded();
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
// the target grip has no button: it moves nothing, so a choice counts at once
const aim = document.querySelector("form[data-at-once]");
function fitAim() {
  const kind = aim.elements.object.value;
  for (const part of aim.querySelectorAll("[data-of]")) part.hidden = !part.dataset.of.split(" ").includes(kind);
  aim.querySelector("[data-size]").textContent = kind === "box" ? WORDS.thickness : WORDS.diameter;
}
let wanted = null;
let asking = false;
async function askAim() { // one request at a time, always the newest choice: answers never overtake each other
  if (asking) return;
  asking = true;
  try {
    while (wanted) {
      const fields = wanted;
      wanted = null;
      await ask("/live/target", fields);
    }
  } finally {
    asking = false;
  }
}
aim.addEventListener("change", () => {
  fitAim();
  if (!aim.reportValidity()) return;
  wanted = Object.fromEntries(new FormData(aim));
  askAim();
});
fitAim();

for (const button of all("[data-do]")) {
  button.addEventListener("click", async () => {
    if (button.dataset.do !== "approve") return void ask("/live/" + button.dataset.do, {});
    if (await ask("/takes/" + now.take + "/approve", { back: "live" })) await listTakes(now.take);
  });
}
// assessments and the fit: the same form, another verb
const order = byId("panel-play");
for (const button of all("[data-ask]")) {
  button.addEventListener("click", () => {
    if (order.reportValidity()) ask("/live/" + button.dataset.ask, Object.fromEntries(new FormData(order)));
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
    const step = event.key === "ArrowRight" ? 1 : tabs.length - 1;
    const other = tabs[(tabs.indexOf(tab) + step) % tabs.length];
    choose(other);
    other.focus();
  });
}
if (location.hash === "#record") choose(byId("tab-record"));
if (location.hash === "#assess") byId("assess").open = true;
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
  const them = now.busy || now.state === "stopped" ? now.patient : now.session_course?.who;
  const recording = ["countdown", "recording", "processing"].includes(now.state);
  if (recording) {
    fill("name", WORDS.demonstrating); fill("born", ""); fill("side", handOf(now.side));
  } else if (now.busy && !them) {
    fill("name", WORDS.nobody); fill("born", ""); fill("side", handOf(now.side));
  } else if (them) {
    fill("name", them.name); fill("born", WORDS.born + " " + them.born); fill("side", handOf(them.side));
  } else if (chosen && chosen.value) {
    fill("name", chosen.dataset.name); fill("born", chosen.dataset.born);
    fill("side", handOf(chosen.dataset.side));
  } else {
    fill("name", WORDS.nobody); fill("born", ""); fill("side", "");
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
  fill("run", now.run);
  fill("counted", { range: WORDS.posture, tone: WORDS.stretch }[now.kind] ?? WORDS.repetition);
  figure("repetition", playing && now.repetitions && now.repetition > 0 ? told("counted", { n: now.repetition, m: now.repetitions }) : "");
  figure("tracking", now.state === "recording" && now.tracking_percent !== null ? `${now.tracking_percent} %` : "");
  showTarget();
  showQuality();
  showPatient();
  confirmStill();
  if (performance.now() > refusedUntil) say(now.message, now.state === "failed" ? "bad" : now.paused ? "caution" : "");
  showDesk();
  if (now.state === "done" && now.take && !now.session && now.take !== knownTake) listTakes("");
  document.dispatchEvent(new Event("live-state"));
  if (now.state !== lastState) { lastState = now.state; if (now.state === "done" || now.state === "failed") askLimits(); }
}

function showTarget() {
  const to = now.target.to_go_mm;
  figure("target", to === null ? "" : `${to} mm (${now.target.farthest})`);
  fill("target-words", now.target.refused ? WORDS.impossible : now.target.words || WORDS.none);
  fill("target-why", now.target.refused ? now.target.words : "");
  byId("aim").dataset.refused = String(now.target.refused);
  byId("aim").hidden = ["countdown", "recording", "processing"].includes(now.state);
  for (const part of aim.elements) part.disabled = main.dataset.mayPlay === "no";
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
  fill("dropped", now.dropped ? ", " + told("dropped", { n: now.dropped }) : "");
  byId("quality").setAttribute("aria-label", known ? told("shares", { measured: shares.measured, estimated, lost }) : WORDS.unnamed);
}

function showDesk() {
  byId("idle-desk").hidden = now.busy || now.state === "stopped";
  byId("busy-desk").hidden = !now.busy;
  for (const part of all("#busy-desk [data-in]")) part.hidden = !part.dataset.in.split(" ").includes(now.state);
  for (const part of all("#busy-desk [data-act]")) {
    const words = now.acts[part.dataset.do];
    part.hidden = words === undefined;
    if (words !== undefined && part.textContent !== words) part.textContent = words;
  }
  if (now.kind === "tone") byId("speed").closest("label").hidden = true; // its three speeds are what it measures
  list("notes", now.notes);
  byId("notes").hidden = !now.notes.length;
  if (main.dataset.mayPlay === "no") for (const part of all("#busy-desk button:not([data-do=pain]), #speed")) part.disabled = true;
  byId("countdown").hidden = now.state !== "countdown";
  byId("countdown").firstElementChild.textContent = String(Math.ceil(now.countdown_s));
  if (!heldSpeed && now.speed_percent) {
    byId("speed").value = String(now.speed_percent);
    byId("speed-out").textContent = now.speed_percent + " %";
  }
  const ended = now.state === "done" || now.state === "stopped";
  byId("after").hidden = !(ended && (now.session || (now.take && !now.kind)));
  for (const part of all("[data-after=take]")) part.hidden = Boolean(now.session || now.kind) || !now.take;
  for (const part of all("[data-after=session]")) part.hidden = !now.session;
  const assessed = now.session && now.patient && ["range", "tone", "tracking"].includes(now.kind);
  for (const part of all("[data-after=assessed]")) part.hidden = !assessed;
  fill("take", now.take); fill("session", now.session);
  link("take", "/takes/" + now.take);
  link("session", "/sessions/" + now.session);
  link("report", "/sessions/" + now.session + "/report");
  if (assessed) link("assessments", "/patients/" + now.patient.id + "/assessments");
}

function link(name, path) {
  for (const place of all(`[data-link="${name}"]`)) place.setAttribute("href", path);
}

async function listTakes(chosen) {
  knownTake = now.take;
  const list = document.querySelector("select[name=take]");
  const kept = chosen || list.value;
  const query = new URLSearchParams({ keep: kept, take: now.take });
  const answer = await fetch("/live/takes?" + query, { headers: { Accept: "application/json" } });
  if (!answer.ok) return;
  const { rows, total, take: mine } = await answer.json();
  const approve = document.querySelector("[data-do=approve]");
  if (approve && mine) {
    approve.disabled = Boolean(mine.approved_by);
    approve.textContent = mine.approved_by ? "✓ " + WORDS.approved : "✓ " + WORDS.approve;
  }
  if (rows.length) list.replaceChildren(...rows.map((row) => new Option(row.shown, row.id, false, row.id === kept)));
  document.querySelector("[data-chooser=take]").hidden = total <= rows.length;
  if (chosen) choose(byId("tab-play"));
}

// --- whom it is for: name, birth date and side are compared by a person before anything moves

let lastState = "";
let limitsAsked = 0;

function list(name, sentences) {
  const place = document.querySelector(`[data-list=${name}]`);
  if (place.dataset.said === sentences.join("\n")) return;
  place.dataset.said = sentences.join("\n");
  place.replaceChildren(...sentences.map((text) => {
    const item = document.createElement("li");
    item.textContent = text;
    return item;
  }));
  place.scrollTop = place.scrollHeight;
}

// Asked again for each patient: also when somebody else's hand was in the robot since, or the page was covered.
function confirmStill() {
  const box = order.elements.present;
  const other = [now.busy ? now.patient?.id : "", now.session_course?.who?.id].some((id) => id && id !== box.value);
  const covered = byId("cover") !== null && !byId("cover").hidden;
  if (box.checked && (other || covered)) box.checked = false;
}

function confirmAnew() {
  const chosen = order.elements.patient.selectedOptions[0];
  const box = order.elements.present;
  byId("confirm").hidden = !chosen.value;
  box.checked = false;
  box.required = Boolean(chosen.value);
  box.value = chosen.value;
  if (chosen.value) fill("who", `${chosen.dataset.name}, ${chosen.dataset.born}, ${handOf(chosen.dataset.side)}`);
  showPatient();
}

async function askLimits() {
  const asked = ++limitsAsked;
  const { patient, device, wrist } = order.elements;
  const query = new URLSearchParams({ patient: patient.value, device: device.value, wrist: wrist.value });
  const answer = await fetch("/live/limits?" + query, { headers: { Accept: "application/json" } });
  if (!answer.ok || asked !== limitsAsked) return;
  const today = await answer.json();
  fill("limits", today.words);
  byId("limits").dataset.kind = today.kind;
  list("limits", today.more);
  for (const button of all("[data-ask]")) button.disabled = main.dataset.mayPlay === "no" || !today.worn || !today.patient;
  for (const option of order.elements.mode.options) {
    const plain = option.dataset.plain ??= option.textContent;
    option.disabled = option.value in today.locked;
    option.textContent = plain + (option.disabled ? ` (${WORDS.locked})` : "");
  }
  showMode(today.locked);
}

let locks = {};
function showMode(locked) {
  locks = locked ?? locks;
  const mode = order.elements.mode.value;
  byId("locked").hidden = !(mode in locks);
  byId("locked").textContent = locks[mode] ?? "";
  for (const part of order.querySelectorAll("[data-mode]")) part.hidden = part.dataset.mode !== mode;
}

order.elements.patient.addEventListener("change", () => { confirmAnew(); askLimits(); });
order.elements.device.addEventListener("change", askLimits);
order.elements.wrist.addEventListener("change", askLimits);
order.elements.mode.addEventListener("change", () => showMode());
confirmAnew();
askLimits();

// --- cameras: asked for when the list is about to be used, because looking for devices takes a moment

const cameraList = document.querySelector("select[name=camera]");
let cameras = [];

async function listCameras() {
  const answer = await fetch("/live/cameras", { headers: { Accept: "application/json" } });
  if (!answer.ok) return;
  cameras = await answer.json();
  const kept = cameraList.value;
  cameraList.replaceChildren(...cameras.map((one) => {
    const option = new Option(one.ready ? one.words : `${one.words} (${one.state_words})`, one.id, false, one.id === kept);
    option.disabled = !one.ready;
    return option;
  }));
  hintCamera();
}

function hintCamera() {
  const one = cameras.find((item) => item.id === cameraList.value);
  const needs = cameras.filter((item) => !item.ready && item.remedy).map((item) => `${item.words}: ${item.remedy}`);
  const depth = one && !one.has_depth ? WORDS.noDepth + " " : "";
  const virtual = cameraList.value === "virtual" ? WORDS.renders + " " : depth;
  byId("camera-hint").textContent = virtual + needs.join(" ");
}
cameraList.addEventListener("change", hintCamera);
byId("tab-record").addEventListener("click", listCameras);
if (location.hash === "#record") listCameras();

// --- freshness: the picture carries the number of the frame that it shows

let shownFrame = -1;
let shownChangedAt = performance.now();
let sentFrame = -1;
let sentChangedAt = performance.now();
let movingSince = performance.now();
let awaited = []; // frames of a movement that the server told and the picture has not drawn yet, and when

// An answer may have been on its way for long, so it counts from when it was asked for, not from when it came.
function hear(state, askedAt) {
  knownAt = askedAt;
  if (state.frame === sentFrame) return;
  if (state.frame < sentFrame) awaited = []; // a server that began anew counts anew
  if (knownAt - sentChangedAt > 500) movingSince = knownAt; // what stood still was no old picture
  sentFrame = state.frame;
  sentChangedAt = knownAt;
  if (state.state === "playing" && !state.paused) awaited.push([sentFrame, knownAt]);
}

const silent = (clock) => clock - knownAt > 700; // three questions without an answer

// A picture is old when it stands still, and also when it flows but comes late, as over a slow network.
function lag() {
  const mark = frame.contentDocument?.querySelector("[data-frame]");
  const clock = performance.now();
  if (mark && Number(mark.dataset.frame) !== shownFrame) { shownFrame = Number(mark.dataset.frame); shownChangedAt = clock; }
  while (awaited.length && awaited[0][0] <= shownFrame) awaited.shift();
  if (silent(clock)) return clock - knownAt;
  if (!awaited.length) return 0; // drawn, or nothing moved: a picture that never came is as old as the movement
  return clock - Math.min(Math.max(shownChangedAt, movingSince), awaited[0][1]);
}

function tick() {
  const late = lag();
  stale.hidden = late < 300;
  stale.firstElementChild.textContent = silent(performance.now()) ? WORDS.lost : WORDS.stale;
  beat.postMessage({ token: document.body.dataset.token, page, alive: late < 1000, hidden: document.hidden });
}

const beat = new Worker("/static/beat.js");
beat.onmessage = (event) => {
  const { status, said: state, took } = event.data;
  if (status === 401) return void signInEnded();
  if (status !== 200) return;
  hear(state, performance.now() - took);
  show(state);
};
document.addEventListener("visibilitychange", tick);
setInterval(tick, 150);
tick();
