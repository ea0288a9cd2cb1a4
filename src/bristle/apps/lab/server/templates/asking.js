// Requests to the server: each carries the token, which exists only in the fragment of the address.

const settings = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);
const [token, opened, view] = location.hash.slice(1).split(".");

class Refusal extends Error {}

async function asked(method, path, { body = null, headers = {} } = {}) {
  let answer;
  try {
    answer = await fetch(path, { method, body, headers: { "X-Bristle-Token": token, ...headers }, cache: "no-store", redirect: "error" });
  } catch {
    throw new Refusal("bristle does not answer. Start it again: bristle lab --serve");
  }
  if (!answer.ok) {
    const told_ = await answer.json().catch(() => ({}));
    throw Object.assign(new Refusal(told_.message ?? `the server refused the request (HTTP status ${answer.status})`), { status: answer.status });
  }
  return answer;
}

async function json(method, path, data = null) {
  const body = data === null ? {} : { body: JSON.stringify(data), headers: { "Content-Type": "application/json" } };
  return (await asked(method, path, body)).json();
}

// Show an error beside the button of its task, or else at the top.
function fail(message, task = "") {
  const place = byId(`${task}-failed`) ?? byId("failed");
  for (const other of document.querySelectorAll('.alert[role="alert"]')) other.hidden = true;
  place.hidden = !message;
  place.textContent = message;
  if (message) place.scrollIntoView({ block: "nearest" });
  for (const input of document.querySelectorAll("#loop-form input")) input.setAttribute("aria-invalid", String(message.includes(`${input.name}:`)));
}

// Do the work of an action and show its error at the top.
async function doing(work) {
  try {
    fail("");
    await work();
  } catch (error) {
    if (!(error instanceof Refusal)) console.error(error);
    fail(error.message);
  }
}

// Give a file to the browser as a download.
function download(content, label) {
  const address = URL.createObjectURL(content);
  element("a", { href: address, download: label }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}

async function saved(path, name) {
  const answer = await asked("GET", path), label = /filename="?([^"]+)"?/.exec(answer.headers.get("content-disposition") ?? "")?.[1];
  download(await answer.blob(), label ?? name);
}
