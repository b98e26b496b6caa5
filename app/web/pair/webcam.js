/** One picture from a camera; a DIGIT or a GelSight Mini is an ordinary camera to the browser. */

import { Refusal } from "../shared/api.js";

/** Open a camera; throws a Refusal if there is none. */
export async function camera(which = {}) {
  if (!navigator.mediaDevices?.getUserMedia) {
    throw new Refusal("This browser allows no camera here; open the page on localhost or over https.");
  }
  try {
    return await navigator.mediaDevices.getUserMedia({ video: which });
  } catch {
    throw new Refusal("No camera could be opened; connect one and allow the page to use it.");
  }
}

/** Show the camera in `box` until a picture is taken. Returns its PNG, or null if cancelled. */
export async function snapshot(box) {
  const stream = await camera();
  const before = box.innerHTML;
  box.innerHTML =
    '<video autoplay playsinline muted></video><div class="row"><button type="button" class="main">Take it</button><button type="button">Cancel</button></div>';
  const video = box.querySelector("video");
  video.srcObject = stream;
  const [takeIt, cancel] = box.querySelectorAll("button");
  takeIt.focus();
  try {
    return await new Promise((resolve) => {
      cancel.onclick = () => resolve(null);
      takeIt.onclick = () => {
        const canvas = document.createElement("canvas");
        canvas.width = video.videoWidth;
        canvas.height = video.videoHeight;
        canvas.getContext("2d").drawImage(video, 0, 0);
        canvas.toBlob(resolve, "image/png");
      };
    });
  } finally {
    stream.getTracks().forEach((track) => track.stop());
    box.innerHTML = before;
  }
}
