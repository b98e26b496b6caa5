/** Escape any text for HTML. */

const CODES = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#39;" };
export const escaped = (text) => String(text).replace(/[&<>"']/g, (c) => CODES[c]);
export const percent = (share, digits = 0) => `${(100 * share).toFixed(digits)}\u00a0%`;
/** True for a set of signals, drawn as stripes: a pair is two recordings of one signal. */
export const isSignals = ({ encoder }) => encoder === "strip";
export const isSimulated = (name) => name.endsWith("-sim");
