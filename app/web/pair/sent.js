/** Images that the visitor sent: reference -> what the server said of it, and its name. */
export const sent = new Map();
