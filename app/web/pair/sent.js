/** Uploaded images: reference -> the server's reply, and the name. */
export const sent = new Map();
