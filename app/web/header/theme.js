/** Light or dark: what the system says, until the visitor chooses; the browser remembers the choice. */

import { keep, kept } from "../shared/memory.js";

const KEPT = "omnivat-theme";

export function followTheme(button) {
  const chosen = kept(KEPT);
  if (chosen) document.body.classList.toggle("dark", chosen === "dark");
  button.onclick = () => keep(KEPT, document.body.classList.toggle("dark") ? "dark" : "light");
}
