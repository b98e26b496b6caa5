/** What the page offers, as rows of the server: modes of p, measures, steps, colours, methods, rungs, domains. A script
 * goes by what a row can do, never by its name. `app/web/shared/tables.json` has the rows. */

const sent = globalThis.document?.querySelector("#omnivat-tables")?.textContent; // a worker has no document
/** @type {Tables} */
export const TABLES = sent
  ? JSON.parse(sent)
  : { modes: [], measures: [], stages: [], colours: [], methods: [], rungs: [], domains: [] };

/** Return the row of frames' mode of p; one that can do nothing where there is no head.
 * @param {{kind: string}} frames @returns {Mode} */
export const modeOf = ({ kind }) => TABLES.modes.find(({ id }) => id === kind) ?? { id: kind, can: [] };

/** Return whether a row can do something; docs/extend.md lists the abilities.
 * @param {{can?: string[]} | undefined} row
 * @param {string} ability */
export const can = (row, ability) => Boolean(row?.can?.includes(ability));

/** Return whether the mode of frames can. @param {{kind: string}} frames @param {string} ability */
export const has = (frames, ability) => can(modeOf(frames), ability);

/** The mode whose frames are the loaded head's own. */
export const OWN_MODE = TABLES.modes.find((row) => can(row, "own"))?.id ?? "";

/** The rungs that have a map of the twins' touches, the first as they come. */
export const PLACES = TABLES.rungs.filter(({ map }) => map !== undefined);

/** Return the rung that the third chapter draws. @param {{rung: string}} address @returns {Partial<RungRow>} */
export const rungOf = ({ rung }) => TABLES.rungs.find(({ id }) => id === rung) ?? {};

/** Return a domain by its sensor and data set, "GelSight (TAG)"; one of a visitor's set keeps its name.
 * @param {string} domain */
export function sensorOf(domain) {
  const name = domain.replace(/-sim$/, "");
  return TABLES.domains.find(({ id }) => id === name)?.title ?? name;
}

/** Return a row's sentence with the values in place of {names}.
 * @param {string} text @param {Record<string, unknown>} values */
export const worded = (text, values) => text.replace(/\{(\w+)\}/g, (_, name) => String(values[name] ?? ""));
