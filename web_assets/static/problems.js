// A form that comes back: what was changed meanwhile, or is to be corrected, is read first.
"use strict";
document.querySelector("#changed, #problems, #others-warning")?.focus();
