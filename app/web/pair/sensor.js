/** My sensor: a profile of unlabelled pictures, which predictions, familiarity and the map then follow. */

import {
  button,
  chooser,
  folded,
  hint,
  html,
  IMAGES,
  imagesOf,
  kinds,
  OTHER,
  options,
  plural,
  row,
  status,
  TERMS,
  table,
  titleOf,
} from "./parts.js";
import { brief, readingsIn, readingsOf } from "./verdict.js";

/** What a profile was made of, in words. @param {NonNullable<PairTab["counts"]>} counts */
export const madeOf = (counts) =>
  imagesOf(counts)
    .map((name) => plural(counts[name] ?? 0, TERMS[name].one, TERMS[name].many))
    .join(" and ");

/** The panel. @param {PairTab} tab */
export function sensorHtml({ counts, rest, doing, doubt, notes, before, answer }) {
  const use = counts
    ? [button("saveProfile", "Save"), button("profileDropped", "Stop using it")]
    : chooser("load", "Load", html`accept=".safetensors"`);
  const [own, other] = [rest, OTHER[rest]].map((kind) => TERMS[kind].many);
  const question =
    doubt &&
    html`${doubt.strange} of ${doubt.of} pictures look more like ${other} than like ${own}. What are they? ${kinds("sampled")}`;
  const progress =
    doing.sample &&
    html`Reading picture ${doing.sample.done} of ${doing.sample.total}… ${button("samplingStopped", "Cancel")}`;
  const choices = IMAGES.toReversed().map((name) => [name, TERMS[name].many]);
  return html`<h3>My sensor</h3>${hint(counts ? `The profile of ${madeOf(counts)} is in use. Label some pairs to check it.` : "Give 5 to 50 unlabelled pictures of one sensor.")}
    <div class="row">${chooser("sampled", "Pictures", html`multiple`)}${chooser("sampled", "Folder", html`webkitdirectory multiple`)}${use}</div>
    ${folded("Names", html`<label>Pictures without vis or tac in the name are <select name="rest" data-send="arrived">${options(choices, rest)}</select></label>`)}
    ${status(progress ?? question ?? notes.sensor)}${before && answer && comparedHtml(before, answer)}`;
}

/** Each reading of a pair before and after; guesses have no figure. @param {NonNullable<PairTab["before"]>} before @param {Predicted} after */
function comparedHtml(before, after) {
  const then = readingsIn(after);
  const rows = readingsOf(before).map(
    (said, i) => said.label && row(titleOf(said.reading), [brief(said), brief(then[i])]),
  );
  return table("This pair with the profile", ["This pair", "raw", "with the profile"], rows.filter(Boolean));
}
