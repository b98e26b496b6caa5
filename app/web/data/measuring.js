/** Speed and error of the page's results, measured on the server on request. */

import { ask, refused } from "../shared/api.js";
import { held } from "../shared/held.js";
import { escaped } from "../shared/text.js";

const figure = (v) =>
  v === 0
    ? "0"
    : v
        .toExponential(1)
        .replace("e", " · 10^")
        .replace(/10\^([+-]?\d+)/, (_, n) => `10<sup>${n.replace("+", "").replace("-", "−")}</sup>`);
const ms = (v) => (v < 10 ? v.toFixed(1) : v.toFixed(0));

export function measuring(box) {
  if (held) {
    box.textContent = held.alone;
    return;
  }
  box.innerHTML = `<div class="row"><button type="button" class="main">Measure now</button><span class="hint" role="status"></span></div><div class="figures"></div>`;
  const button = box.querySelector("button");
  const note = box.querySelector(".hint");
  button.onclick = async () => {
    button.disabled = true;
    note.textContent = "Measuring… about ten seconds; the first time, the head is loaded, too.";
    try {
      box.querySelector(".figures").innerHTML = table(await ask("measure", {}));
      note.textContent = "";
      button.textContent = "Measure again";
    } catch (error) {
      refused(error, (sentence) => {
        note.textContent = sentence;
      });
    } finally {
      button.disabled = false;
    }
  };
}

function table({ rows, pairs, width, repeats, threads, processors }) {
  const lines = rows.map(
    (row) =>
      `<tr><th scope="row">${escaped(row.what)}</th><td><b>${ms(row.ms.median)}</b> <small>${ms(row.ms.least)} to ${ms(row.ms.most)}</small></td><td>${figure(row.error)}<br><small>${escaped(row.of)}</small></td></tr>`,
  );
  return `<div class="scroll" tabindex="0" role="group" aria-label="Measured speed and error"><table class="measured"><thead><tr><th scope="col">What</th><th scope="col">ms: median, range</th><th scope="col">error</th></tr></thead><tbody>${lines.join("")}</tbody></table></div>
    <p class="hint">${pairs} pairs of this set, D = ${width}, ${threads} ${threads === 1 ? "thread" : "threads"} of ${processors} processors, ${repeats} repeats. The range includes other work on the machine, such as that of other visitors.</p>`;
}
