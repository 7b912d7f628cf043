// A certified OpenID provider with its development forms: oidc_provider.py drives them, deploy/try-sign-in starts it for a look by hand.
// Every name signs in with every password; the claims depend on the name.
//
//   node oidc-provider.mjs FOLDER ADDRESS CALLBACK
//
// FOLDER has oidc-provider in its node_modules, ADDRESS is HOST:PORT, CALLBACK is the redirect URI of the service.
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { argv } from 'node:process';
import { pathToFileURL } from 'node:url';

const [folder, address, callback] = argv.slice(2);
// An import looks for packages next to this file only.
const entry = createRequire(join(folder, 'package.json')).resolve('oidc-provider');
const { default: Provider } = await import(pathToFileURL(entry).href);

/** Registration number of a user, the same at each start. */
function numberOf(name) {
  return String([...name].reduce((sum, letter) => (sum * 31 + letter.codePointAt(0)) % 100000, 7)).padStart(5, '0');
}

/** Claims of a user: staff have names that begin with "teacher". */
function claimsOf(name) {
  const isStaff = name.startsWith('teacher');
  return {
    sub: name,
    name: name[0].toUpperCase() + name.slice(1),
    email: name.includes('@') ? name : `${name}@example.org`,
    email_verified: true,
    matriculation: isStaff ? undefined : numberOf(name),
    affiliation: [isStaff ? 'staff@uni.example' : 'student@uni.example'],
  };
}

const client = { redirect_uris: [callback], grant_types: ['authorization_code'], response_types: ['code'] };
const byKey = {
  token_endpoint_auth_method: 'private_key_jwt',
  token_endpoint_auth_signing_alg: 'RS256',
  jwks_uri: new URL('/.well-known/jwks.json', callback).href,
};

const provider = new Provider(`http://${address}`, {
  clients: [
    { ...client, client_id: 'stylet', client_secret: 'a-secret-for-a-trial' },
    { ...client, ...byKey, client_id: 'stylet-by-key' },
  ],
  clientAuthMethods: ['client_secret_basic', 'private_key_jwt'],
  claims: {
    openid: ['sub'],
    profile: ['name', 'matriculation', 'affiliation'],
    email: ['email', 'email_verified'],
  },
  findAccount: (_, name) => ({ accountId: name, claims: () => claimsOf(name) }),
  cookies: { keys: ['a key for a trial'] },
  features: { devInteractions: { enabled: true } },
  // The key set of the service is on the loopback interface, which the usual dispatcher refuses.
  fetch: (url, { dispatcher: _, ...options }) => globalThis.fetch(url, options),
});

const [host, port] = address.split(':');
provider.listen(Number(port), host);
