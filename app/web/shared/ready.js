/** `data-ready` on the body: there while no reply and no delayed step is on its way. */

let going = 0;

function arrived() {
  going -= 1;
  if (!going) document.body.dataset.ready = "";
}

/** Return the result of `work`. The page is not ready before that, nor before what follows from it at once.
 * @template T @param {Promise<T>} work @returns {Promise<T>} */
export async function awaited(work) {
  going += 1;
  delete document.body.dataset.ready;
  try {
    return await work;
  } finally {
    setTimeout(arrived);
  }
}

/** Return a function that runs `act` a pause after its last call; the page is not ready before.
 * @param {() => void} act @param {number} ms @returns {() => void} */
export function afterwards(act, ms) {
  let timer = 0;
  /** @type {(value?: unknown) => void} */
  let over = () => {};
  return () => {
    clearTimeout(timer);
    over(); // the pause before; the page stays unready, as the new one has begun at once
    awaited(new Promise((done) => (over = done)));
    timer = setTimeout(() => {
      act();
      over();
    }, ms);
  };
}
