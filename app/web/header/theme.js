/** Light or dark: what the system says, until the visitor chooses; the browser remembers the choice. Paper is light. */

import { keep, kept } from "../shared/memory.js";

const KEPT = "omnivat-theme";

export function followTheme(button) {
  const chosen = kept(KEPT);
  if (chosen) document.body.classList.toggle("dark", chosen === "dark");
  let dark = false;
  const onPaper = () => {
    dark = document.body.classList.contains("dark");
    document.body.classList.remove("dark");
  };
  addEventListener("beforeprint", onPaper, { capture: true }); // before the maps draw
  addEventListener("afterprint", () => document.body.classList.toggle("dark", dark));
  button.onclick = () => keep(KEPT, document.body.classList.toggle("dark") ? "dark" : "light");
}
