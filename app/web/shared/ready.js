/** `data-ready` on the body: there while no reply and no delayed step is on its way. */

let going = 0;

function arrived() {
  going -= 1;
  if (!going) document.body.dataset.ready = "";
}

/** The result of `work`. The page is not ready before that, nor before what follows from it at once.
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
