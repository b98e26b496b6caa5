/** Tables as CSV, out and in. No DOM here. */

/** Return a cell: quoted where needed, and never a formula; numbers stay numbers. @param {string | number} value */
export const cell = (value) => {
  const text = /^ *[=+\-@\t\r]/.test(String(value)) && !Number.isFinite(Number(value)) ? `'${value}` : String(value);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

/** Return the rows of a table as text. @param {(string | number)[][]} rows */
export const csv = (rows) => `${rows.map((row) => row.map(cell).join(",")).join("\n")}\n`;

/** Return cells of a CSV, row by row; quoted cells may hold commas, quotes and line ends. @param {string} text */
export function cells(text) {
  const rows = [[""]];
  for (const [, quoted, bare, end] of text
    .replace(/^\ufeff/, "")
    .matchAll(/(?:"((?:[^"]|"")*)"|([^",\r\n]*))(,|\r?\n|$)/g)) {
    const row = rows[rows.length - 1];
    row[row.length - 1] = quoted?.replaceAll('""', '"') ?? bare.trim();
    if (end === ",") row.push("");
    else if (end) rows.push([""]);
    else break;
  }
  return rows.filter((row) => row.some(Boolean));
}
