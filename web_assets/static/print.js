// Prints the report, and takes the waiting line away once it is there.
"use strict";
const paper = document.getElementById("report");
const waitingLine = document.getElementById("rendering");
document.getElementById("print").addEventListener("click", () => paper.contentWindow.print());
const arrived = () => { waitingLine.hidden = true; };
paper.addEventListener("load", arrived);
if (paper.contentDocument && paper.contentDocument.readyState === "complete" && paper.contentDocument.body.children.length) arrived();
