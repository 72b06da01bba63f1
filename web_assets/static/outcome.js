// The form of an outcome measure follows the choice at once; without scripts the button beside it does.
"use strict";
const choice = document.getElementById("choose-measure");
if (choice) {
  choice.querySelector("button").hidden = true;
  choice.querySelector("select").addEventListener("change", () => choice.requestSubmit());
}
