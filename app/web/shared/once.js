/** Make a value once, and share it. */

/** Return a function that makes the value of a key once; after a failure, the next call makes it again.
 * @returns {<T>(key: string, make: () => Promise<T>) => Promise<T>} */
export function keeper() {
  /** @type {Map<string, Promise<any>>} */
  const kept = new Map();
  return (key, make) => {
    const before = kept.get(key);
    if (before) return before;
    const made = make();
    kept.set(key, made);
    made.catch(() => kept.delete(key));
    return made;
  };
}
