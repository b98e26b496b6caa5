/** Which set a chapter of Explore shows. */

const LESSON = "chirps"; // the set on which p decides
const SENSORS = "sensors";
/** Return the set of a chapter, by name; "" is the page's own. `listed` are the sets of the project.
 * @param {string} chapter @param {SetRow[]} listed */
export function setOf(chapter, listed) {
  const shown = listed.find((set) => set.shown)?.name;
  const wanted = { order: LESSON, fooled: SENSORS }[chapter];
  if (!shown && chapter !== "order") return "";
  return wanted && wanted !== shown && listed.some(({ name }) => name === wanted) ? wanted : "";
}
