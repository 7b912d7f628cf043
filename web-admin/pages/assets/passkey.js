// Asks the browser for a passkey, and sends its answer with the form around it. Without it, codes do.

/** Bytes of a text in base64url, and back. */
const decoded = (text) => Uint8Array.from(atob(text.replace(/-/g, "+").replace(/_/g, "/")), (c) => c.charCodeAt(0));
const encoded = (bytes) =>
  btoa(String.fromCharCode(...new Uint8Array(bytes))).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "");

/** What the page asks, as the browser takes it. */
function question(ask) {
  const { publicKey } = JSON.parse(ask.dataset.options);
  publicKey.challenge = decoded(publicKey.challenge);
  if (publicKey.user) publicKey.user.id = decoded(publicKey.user.id);
  const keys = [...(publicKey.excludeCredentials ?? []), ...(publicKey.allowCredentials ?? [])];
  for (const key of keys) key.id = decoded(key.id);
  return publicKey;
}

/** What a passkey has answered, as the service takes it. */
function said({ id, rawId, type, response }) {
  const part = (name) => (response[name] ? encoded(response[name]) : null);
  const common = { clientDataJSON: part("clientDataJSON") };
  const own = response.attestationObject
    ? { attestationObject: part("attestationObject"), transports: response.getTransports?.() }
    : { authenticatorData: part("authenticatorData"), signature: part("signature"), userHandle: part("userHandle") };
  return JSON.stringify({ id, rawId: encoded(rawId), type, response: { ...common, ...own } });
}

/** Whether this page is one that the passkeys answer to. */
function isAtHome(publicKey) {
  const host = publicKey.rpId ?? publicKey.rp.id;
  return location.hostname === host || location.hostname.endsWith(`.${host}`);
}

function prepare(ask) {
  const [form, button, note] = [ask.closest("form"), ask.querySelector("button"), ask.querySelector("[role=status]")];

  function tell(words, isBad) {
    note.textContent = words;
    note.classList.toggle("bad", isBad);
    note.hidden = false;
  }

  async function run() {
    const publicKey = question(ask);
    if (!isAtHome(publicKey)) return tell(ask.dataset.elsewhere, true);
    if (!window.PublicKeyCredential) return tell(ask.dataset.absent, true);
    button.disabled = true;
    tell(ask.dataset.waiting, false);
    try {
      const { credentials } = navigator;
      const answer = publicKey.user ? await credentials.create({ publicKey }) : await credentials.get({ publicKey });
      form.elements.answer.value = said(answer);
      // The code in the same form is not asked for any more.
      form.submit();
    } catch (why) {
      button.disabled = false;
      const reasons = { NotAllowedError: ask.dataset.cancelled, InvalidStateError: ask.dataset.known };
      tell(reasons[why.name] ?? ask.dataset.failed, true);
    }
  }

  button.hidden = false;
  button.addEventListener("click", () => {
    const others = [...form.elements].filter((field) => field.name !== "code");
    if (others.every((field) => field.reportValidity())) run();
  });
  if ("atOnce" in ask.dataset) run();
}

document.querySelectorAll("[data-options]").forEach(prepare);
