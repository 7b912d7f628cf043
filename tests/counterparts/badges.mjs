// A second implementation of Data Integrity (@digitalbazaar) verifies badges, and checks their status by the published list.
//
//   badges.mjs FOLDER CASES
//
// FOLDER has the packages in its node_modules. CASES is a file with JSON: `contexts` and `documents` by address, and `cases`, each with the
// text of a badge and the expected result: genuine, revoked or refused. Nothing is fetched.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { argv, exit } from 'node:process';
import { pathToFileURL } from 'node:url';
import { gunzipSync } from 'node:zlib';

const require = createRequire(join(argv[2], 'package.json'));
const load = (name) => import(pathToFileURL(require.resolve(name)));
const vc = await load('@digitalbazaar/vc');
const { DataIntegrityProof } = await load('@digitalbazaar/data-integrity');
const { cryptosuite } = await load('@digitalbazaar/eddsa-rdfc-2022-cryptosuite');
const { contexts, documents, cases } = JSON.parse(readFileSync(argv[3], 'utf8'));
const suite = new DataIntegrityProof({ cryptosuite });

/** Returns a document by its address; a key of an issuer stands in the issuer's document. */
async function documentLoader(url) {
  const [address, fragment] = url.split('#');
  let document = contexts[url] ?? documents[address];
  if (document && fragment && url.startsWith('did:')) {
    document = document.verificationMethod.find(({ id }) => id === url);
    document &&= { '@context': 'https://w3id.org/security/multikey/v1', ...document };
  }
  if (!document) throw new Error(`${url} is not known`);
  return { contextUrl: null, documentUrl: url, document };
}

/** Verifies the list that a badge names, and returns whether the badge is revoked by it. */
async function isRevoked({ credentialStatus, issuer }) {
  const { statusListCredential, statusListIndex } = credentialStatus;
  const list = documents[statusListCredential];
  const { verified, error } = await vc.verifyCredential({ credential: list, suite, documentLoader });
  if (!verified || list.issuer !== issuer.id) throw error ?? new Error('the list of another issuer');
  const bits = gunzipSync(Buffer.from(list.credentialSubject.encodedList.slice(1), 'base64url'));
  const index = Number(statusListIndex);
  return Boolean(bits[index >> 3] & (0x80 >> (index & 7)));
}

/** Returns the verdict of the packages on a badge. */
async function judge(text) {
  let credential;
  try {
    credential = JSON.parse(text);
  } catch {
    return 'refused';
  }
  let listed;
  const checkStatus = async () => {
    listed = await isRevoked(credential);
    return { verified: !listed };
  };
  const { verified } = await vc.verifyCredential({ credential, suite, documentLoader, checkStatus });
  if (verified) return 'genuine';
  return listed ? 'revoked' : 'refused';
}

const counts = {};
for (const { text, expected } of cases) {
  const judged = await judge(text);
  if (judged !== expected) {
    console.error(`failed: @digitalbazaar/vc: ${judged} instead of ${expected}: ${text}`);
    exit(1);
  }
  counts[judged] = (counts[judged] ?? 0) + 1;
}
console.log('@digitalbazaar/vc:', counts);
