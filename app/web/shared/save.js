/** Download a file. */

/** Let the visitor save a file. @param {string} name @param {Blob | string} what a text is a table */
export function save(name, what) {
  const blob = typeof what === "string" ? new Blob([what], { type: "text/csv" }) : what;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
