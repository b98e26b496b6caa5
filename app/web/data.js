/** soon */ export function start() {}
