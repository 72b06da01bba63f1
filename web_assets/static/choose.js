// A field that searches what a select can choose: the server answers with a few, one of which is chosen.
// The select alone holds the choice. Escape is the stop on every page, so nothing here listens to it.
"use strict";
for (const place of document.querySelectorAll("[data-chooser]")) {
  const list = document.querySelector(`select[name="${place.dataset.chooser}"]`);
  const besides = document.querySelector(`select[name="${place.dataset.besides}"]`);
  const field = place.querySelector("input");
  const found = place.querySelector("[role=listbox]");
  const float = place.querySelector(".sought"); // it covers what is below and moves nothing under a finger
  const said = place.querySelectorAll("p");
  const told = (key, values) => place.dataset[key].replace(/\{(\w+)\}/g, (_, name) => values[name]);
  let rows = [];
  let active = -1;
  let asked = 0; // an answer that another question has overtaken counts no more
  let timer = 0;

  const say = (text) => {
    for (const one of said) one.textContent = text;
    float.hidden = !text;
  };

  const close = (text = "") => {
    asked += 1;
    clearTimeout(timer);
    rows = [];
    active = -1;
    found.hidden = true;
    field.setAttribute("aria-expanded", "false");
    field.removeAttribute("aria-activedescendant");
    say(text);
  };

  const mark = (index) => {
    active = index;
    [...found.children].forEach((item, at) => item.setAttribute("aria-selected", String(at === active)));
    if (active < 0) return field.removeAttribute("aria-activedescendant");
    field.setAttribute("aria-activedescendant", found.children[active].id);
    found.children[active].scrollIntoView({ block: "nearest" });
  };

  const optionOf = (row) => {
    const option = new Option(row.shown, row.id);
    Object.assign(option.dataset, row.data);
    return option;
  };

  const pick = (row) => {
    const known = [...list.options].find((option) => option.value === row.id);
    const option = optionOf(row);
    if (known) known.replaceWith(option);
    else list.insertBefore(option, [...list.options].find((other) => other.value) ?? null);
    list.value = row.id;
    field.value = "";
    close();
    list.dispatchEvent(new Event("change", { bubbles: true }));
    list.focus();
  };

  const line = (row, index) => {
    const item = document.createElement("li");
    item.id = `${found.id}-${index}`;
    item.setAttribute("role", "option");
    item.setAttribute("aria-selected", "false");
    const name = Object.assign(document.createElement("b"), { textContent: row.name, dir: "auto" });
    const more = Object.assign(document.createElement("small"), { textContent: `${row.more}, ` });
    more.append(Object.assign(document.createElement("code"), { textContent: row.id }));
    item.append(name, more);
    item.addEventListener("pointerdown", (event) => event.preventDefault()); // the field keeps the focus
    item.addEventListener("click", () => pick(row));
    return item;
  };

  const show = (answer) => {
    rows = answer.rows;
    active = -1;
    found.replaceChildren(...rows.map(line));
    found.hidden = !rows.length;
    field.setAttribute("aria-expanded", String(rows.length > 0));
    const all = rows.length === answer.total;
    say(!rows.length ? told("nothing") : told(all ? "found" : "more", { n: rows.length, m: answer.total }));
    float.scrollIntoView({ block: "nearest" });
  };

  const answerTo = async (query) => {
    if (besides) query.exercise = besides.value;
    const answer = await fetch(`${place.dataset.url}?${new URLSearchParams(query)}`, { headers: { Accept: "application/json" } });
    if (!answer.ok) throw new Error(String(answer.status));
    return answer.json();
  };

  const search = async () => {
    clearTimeout(timer);
    const mine = ++asked;
    const text = field.value.trim();
    if (!text) return void close(told("hint"));
    try {
      const answer = await answerTo({ find: text });
      if (mine === asked) show(answer);
    } catch {
      if (mine === asked) close(told("silent"));
    }
  };

  field.addEventListener("input", () => {
    mark(-1); // what is marked was found by other words
    clearTimeout(timer);
    timer = setTimeout(search, 150);
  });
  field.addEventListener("keydown", async (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step && rows.length) {
      event.preventDefault();
      mark((active + step + rows.length + (active < 0 && step < 0 ? 1 : 0)) % rows.length);
    } else if (event.key === "Enter") {
      event.preventDefault(); // it must never start what the form around it starts
      if (active >= 0) return pick(rows[active]);
      const text = field.value;
      await search();
      if (field.value === text && rows.length === 1) mark(0); // one more Enter takes it
    }
  });
  place.addEventListener("focusout", (event) => { if (!place.contains(event.relatedTarget)) close(); });
  place.addEventListener("focusin", () => { if (found.hidden) search(); });

  // takes of another exercise: the list follows
  besides?.addEventListener("change", async () => {
    close();
    const mine = asked;
    const answer = await answerTo({}).catch(() => null);
    if (!answer || mine !== asked) return;
    const fixed = [...list.options].filter((option) => !option.value);
    list.replaceChildren(...fixed, ...answer.rows.map(optionOf));
    place.hidden = answer.total <= answer.rows.length;
  });
}
