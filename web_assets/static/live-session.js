// The session runner: shows the step that the server keeps, sends what the person does. Texts come from the page.
"use strict";
const sessionPanel = byId("panel-session");
const words = sessionPanel.dataset;
const SIGN_OF = { now: "●", done: "✓", skipped: "–", open: "○" };
let course = null;
let shownVersion = "";
let painEntry = 0;
let noteFor = "";

// --- the stepper

function clock(seconds) {
  return `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;
}

function showSteps() {
  byId("course").hidden = !course;
  if (!course) return;
  const place = document.querySelector("[data-list-of=steps]");
  const key = course.steps.map((step) => step.key + step.state).join();
  if (place.dataset.shown !== key) {
    place.dataset.shown = key;
    place.replaceChildren(...course.steps.map((step, index) => {
      const item = document.createElement("li");
      const button = document.createElement("button");
      button.type = "button";
      button.dataset.state = step.state;
      button.textContent = `${SIGN_OF[step.state]} ${index + 1} ${step.words}`;
      button.setAttribute("aria-label", `${index + 1} ${step.words}: ${place.dataset[step.state]}`);
      if (step.state === "now") button.setAttribute("aria-current", "step");
      button.addEventListener("click", () => { if (step.state !== "now") goTo(step.key); });
      item.append(button);
      return item;
    }));
    place.querySelector("[aria-current]")?.scrollIntoView({ block: "nearest", inline: "center" });
  }
  for (const button of place.querySelectorAll("button")) button.disabled = now.busy || main.dataset.mayPlay === "no";
  fill("total", `${clock(course.total_s)} / ${course.total_minutes} ${words.minutes}`);
}

function goTo(key) {
  if (key) ask("/live/session/step", { at: course.step, to: key, reason: byId("step-reason").value });
}

// --- the step

function showStep() {
  byId("session-begin").hidden = Boolean(course);
  byId("session-step").hidden = !course;
  if (!course) { shownVersion = ""; noteFor = ""; return; }
  byId("step-spent").textContent = `${clock(course.spent_s)} / ${course.minutes} ${words.minutes}`;
  byId("step-spent").dataset.over = String(course.spent_s > 60 * course.minutes);
  const done = course.done;
  byId("step-next").textContent = `${done ? words.next : words.skip} ›`;
  byId("step-next").hidden = !course.next;
  byId("step-next").className = done ? "primary" : "";
  byId("step-why").hidden = done || !course.next;
  byId("step-back").disabled = !course.back;
  if (shownVersion === `${course.version}${now.session}`) return;
  const stepped = byId("session-step").dataset.step !== course.step;
  shownVersion = `${course.version}${now.session}`;
  byId("session-step").dataset.step = course.step;
  byId("step-words").textContent = `${course.number} ${course.words}`;
  byId("step-told").textContent = course.told;
  if (stepped) byId("step-reason").value = "";
  for (const form of sessionPanel.querySelectorAll("form[data-step]")) form.hidden = form.dataset.step !== course.step;
  byId("session-start").hidden = course.starts === "";
  for (const part of sessionPanel.querySelectorAll("[data-for]")) part.hidden = !part.dataset.for.split(" ").includes(course.starts);
  byId("step-start").textContent = "▶ " + (byId("step-start").dataset[course.starts] ?? "");
  byId("step-choices").hidden = course.starts !== "play";
  if (course.starts === "play") listChoices();
  if (course.step === "note" && noteFor !== course.patient + course.total_minutes) writeNote();
  if (course.step !== "note") noteFor = "";
}

async function listChoices() {
  const answer = await fetch("/live/session/choices", { headers: { Accept: "application/json" } });
  if (!answer.ok) return;
  const rows = await answer.json();
  const place = byId("step-choices");
  const first = rows.find((row) => row.ready);
  place.replaceChildren(...rows.map((row) => {
    const label = document.createElement("label");
    const input = Object.assign(document.createElement("input"), { type: "radio", name: "choice", value: row.key, disabled: !row.ready, checked: row === first });
    const text = document.createElement("span");
    const name = document.createElement("b");
    name.textContent = row.words;
    const dose = document.createElement("span");
    dose.textContent = row.ready ? row.dose : row.why;
    text.append(name, dose);
    if (row.remark) text.append(Object.assign(document.createElement("em"), { textContent: row.remark }));
    label.append(input, text);
    return label;
  }));
  const hint = document.createElement("p");
  hint.className = "hint";
  hint.textContent = !first ? words.nothing : rows.some((row) => row.prescribed) ? words.prescribed : words.proposed;
  place.prepend(hint);
  byId("step-start").disabled = !first || main.dataset.mayPlay === "no";
}

async function writeNote() {
  noteFor = course.patient + course.total_minutes;
  byId("note-text").value = "";
  const answer = await fetch("/live/session/note", { headers: { Accept: "application/json" } });
  if (!answer.ok) return;
  const told = await answer.json();
  byId("note-heading").textContent = told.heading;
  byId("note-text").value = told.text;
}

async function copyNote() {
  const text = `${byId("note-heading").textContent}\n${byId("note-text").value}`;
  try {
    await navigator.clipboard.writeText(text);
    byId("note-copy").textContent = "✓ " + words.copied;
  } catch (refused) { // no clipboard without TLS: the old way, from a field that can be selected
    const field = Object.assign(document.createElement("textarea"), { value: text });
    document.body.append(field);
    field.select();
    const copied = document.execCommand("copy");
    field.remove();
    byId("note-copy").textContent = copied ? "✓ " + words.copied : words.notCopied;
    if (!copied) byId("note-text").select();
  }
}

for (const form of sessionPanel.querySelectorAll("form[data-session]")) {
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const fields = Object.fromEntries(new FormData(form));
    if (form.dataset.session === "start") {
      fields.at = course.step;
      fields.device = order.elements.device.value;
      fields.twin = order.elements.twin.value;
    }
    if (!(await ask("/live/session/" + form.dataset.session, fields))) return;
    if (form.dataset.session === "check-in" || form.dataset.session === "begin") form.reset();
    if (form.dataset.session === "end") { noteFor = ""; confirmSession(); }
  });
}
byId("note-copy").addEventListener("click", copyNote);
byId("step-back").addEventListener("click", () => goTo(course.back));
byId("step-next").addEventListener("click", () => goTo(course.next));

function confirmSession() {
  const chosen = byId("session-begin").elements.whom.selectedOptions[0];
  const box = byId("session-begin").elements.present;
  byId("session-confirm").hidden = !chosen.value;
  box.checked = false;
  box.value = chosen.value;
  fill("session-who", chosen.dataset.who ?? "");
}
byId("session-begin").elements.whom.addEventListener("change", confirmSession);
confirmSession();

// --- pain, by one tap; more about it may follow

async function tapPain(fields) {
  const answer = await fetch("/live/pain", {
    method: "POST",
    headers: { Accept: "application/json", "X-Form-Token": document.body.dataset.token },
    body: new URLSearchParams({ ...fields, page }),
  });
  const told = await answer.json().catch(() => ({ message: WORDS.noAnswer }));
  if (answer.ok) painEntry = told.entry;
  fill("pain", told.message);
  byId("pain-more").hidden = false;
  return answer.ok;
}
byId("pain-tap").addEventListener("click", () => {
  byId("pain-place").value = "";
  for (const button of all("#pain-more [data-score]")) button.removeAttribute("aria-pressed");
  tapPain({});
});
function painScore() { return document.querySelector("#pain-more [aria-pressed=true]")?.dataset.score ?? ""; }
for (const button of all("#pain-more [data-score]")) {
  button.addEventListener("click", () => {
    for (const other of all("#pain-more [data-score]")) other.setAttribute("aria-pressed", String(other === button));
    tapPain({ score: painScore(), place: byId("pain-place").value, entry: painEntry });
  });
}
byId("pain-place").addEventListener("change", () => tapPain({ score: painScore(), place: byId("pain-place").value, entry: painEntry }));
byId("pain-close").addEventListener("click", () => { byId("pain-more").hidden = true; });

// --- who operates

byId("operate").addEventListener("click", () => ask("/live/operate", {}));
function showOperator() {
  const runs = now.state === "playing" || now.state === "rehearsing";
  figure("operator", runs ? now.operator_words : "");
  byId("operate").hidden = !runs || now.operator || main.dataset.mayPlay === "no";
}

// --- a restart of the server: what was interrupted is named, and the picture is asked for anew

let server = "";
function showRestart() {
  if (server && server !== now.server) frame.contentWindow.location.reload();
  server = now.server;
  const place = byId("interrupted");
  const told = now.interrupted.map((one) => one.words).join();
  place.hidden = !told;
  if (place.dataset.told === told) return;
  place.dataset.told = told;
  place.replaceChildren(...now.interrupted.map((one) => {
    const item = document.createElement("li");
    item.append(one.path ? Object.assign(document.createElement("a"), { href: one.path, textContent: one.words }) : one.words);
    return item;
  }));
}

let hadCourse = false;
document.addEventListener("live-state", () => {
  course = now.session_course;
  if (course && !hadCourse) choose(byId("tab-session"));
  hadCourse = Boolean(course);
  showSteps();
  showStep();
  showOperator();
  showRestart();
});
if (location.hash === "#session") choose(byId("tab-session"));
