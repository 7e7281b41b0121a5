// HTTP to the server the page came from, and to nobody else.

/** An answer that says no; its text is one sentence for the operator. */
export class Refused extends Error {
  constructor(text, status) {
    super(text);
    this.status = status;
  }
}

let client = null;

/** The name the server gave this page; it goes with everything that acts. */
export function setClient(name) {
  client = name;
}

/** GET, POST, PUT or DELETE; the parsed answer. A file is sent as it is. Raises Refused. */
export async function call(method, path, body) {
  const headers = {};
  if (client) headers["X-Labrig-Client"] = client;
  const isFile = body instanceof Blob;
  if (body !== undefined) headers["Content-Type"] = isFile ? body.type : "application/json";
  let answer;
  try {
    answer = await fetch(path, {
      method,
      headers,
      credentials: "same-origin",
      cache: "no-store",
      body: body === undefined || isFile ? body : JSON.stringify(body),
    });
  } catch {
    throw new Refused("The panel's server does not answer.", 0);
  }
  const found = await answer.json().catch(() => ({}));
  if (!answer.ok)
    throw new Refused(found.error || `The server refused (${answer.status}).`, answer.status);
  return found;
}

export const get = (path) => call("GET", path);
export const post = (path, body = {}) => call("POST", path, body);
export const put = (path, body) => call("PUT", path, body);
export const remove = (path) => call("DELETE", path);

/** A query string of what is given and not empty. */
export function query(values) {
  const given = Object.entries(values).filter(([, value]) => value !== "" && value != null);
  return new URLSearchParams(given).toString();
}
