/** Files of a drop or of a file field, with their paths; folders are read to the end. */

const inside = (folder) => {
  const reader = folder.createReader();
  return new Promise((resolve, reject) => {
    const all = [];
    const more = () =>
      reader.readEntries((some) => {
        all.push(...some);
        if (some.length) more();
        else resolve(all);
      }, reject);
    more();
  });
};

async function filesOf(entry, path = "") {
  const name = path + entry.name;
  if (entry.isFile) return [{ path: name, file: await new Promise((resolve, reject) => entry.file(resolve, reject)) }];
  const all = [];
  for (const one of await inside(entry)) all.push(...(await filesOf(one, `${name}/`)));
  return all;
}

/** [{path, file}] of a drop. */
export async function droppedFiles(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean); // before any wait
  if (!entries.some((entry) => entry.isDirectory)) return chosenFiles(transfer.files);
  return (await Promise.all(entries.map((entry) => filesOf(entry)))).flat();
}

/** [{path, file}] of a file field. */
export const chosenFiles = (files) => [...files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
