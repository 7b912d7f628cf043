// A second implementation of SCIM 2.0 (SCIMMY) as a client: it builds the requests, checks each answer by its own schemas, and applies
// each change to its own copy as well, which must then equal the answer.
//
//   scimmy.mjs FOLDER
//
// FOLDER has scimmy in its node_modules. STYLET_URL is the address of the service, STYLET_TOKEN the token of a directory.
import { deepStrictEqual, ok, strictEqual } from 'node:assert/strict';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { argv, env } from 'node:process';

const { default: SCIMMY } = createRequire(join(argv[2], 'package.json'))('scimmy');
const { Messages, Schemas } = SCIMMY;
const USERS = '/Users';
const GROUPS = '/Groups';
const schemaOf = { [USERS]: Schemas.User, [GROUPS]: Schemas.Group };
let checks = 0;

/** Sends a request; returns the status, and the body as JSON if there is one. */
async function send(method, path, body) {
  const answer = await fetch(`${env.STYLET_URL}/scim/v2${path}`, {
    method,
    headers: { authorization: `Bearer ${env.STYLET_TOKEN}`, 'content-type': 'application/scim+json' },
    body: body && JSON.stringify(body),
  });
  const text = await answer.text();
  if (text) ok(answer.headers.get('content-type').startsWith('application/scim+json'), `${path}: the media type`);
  return { status: answer.status, body: text ? JSON.parse(text) : undefined };
}

/** A value as JSON has it, without fields that are undefined. */
function plain(value) {
  return JSON.parse(JSON.stringify(value));
}

/** Reads an answer by a schema, and asserts that nothing of it is lost: every field is one of the schema. */
function readBy(Schema, body) {
  const read = new Schema(body);
  deepStrictEqual(plain({ ...read, meta: body.meta }), body);
  checks += 1;
  return read;
}

async function create(path, fields) {
  const made = await send('POST', path, new schemaOf[path](fields, 'in'));
  strictEqual(made.status, 201, JSON.stringify(made.body));
  return readBy(schemaOf[path], made.body);
}

/** Patches a resource here and there; asserts that both are the same afterwards. */
async function patch(path, resource, operations) {
  const request = { schemas: [Messages.PatchOp.id], Operations: operations };
  const wanted = await new Messages.PatchOp(plain(request)).apply(resource);
  const patched = await send('PATCH', `${path}/${resource.id}`, request);
  strictEqual(patched.status, 200, JSON.stringify(patched.body));
  const read = readBy(schemaOf[path], patched.body);
  deepStrictEqual(plain({ ...read, meta: 0 }), plain({ ...(wanted ?? resource), meta: 0 }), JSON.stringify(operations));
  return read;
}

async function list(path, search) {
  const query = new Messages.SearchRequest({ schemas: [Messages.SearchRequest.id], ...search });
  const { status, body } = await send('POST', `${path}/.search`, query);
  strictEqual(status, 200, JSON.stringify(body));
  const { totalResults, itemsPerPage, startIndex, Resources } = new Messages.ListResponse(body);
  deepStrictEqual(plain({ totalResults, itemsPerPage, startIndex, Resources }), plain({ ...body, schemas: undefined }));
  checks += 1;
  return body.Resources.map((one) => readBy(schemaOf[path], one));
}

/** Asserts that an answer is an error that SCIMMY accepts. */
function assertError({ status, body }, wanted, scimType) {
  strictEqual(status, wanted, JSON.stringify(body));
  // With its schema the message would be thrown again instead of checked.
  deepStrictEqual({ ...new Messages.ErrorResponse({ ...body, schemas: undefined }) }, body);
  strictEqual(body.scimType, scimType);
  checks += 1;
}

async function checkDiscovery() {
  readBy(Schemas.ServiceProviderConfig, (await send('GET', '/ServiceProviderConfig')).body);
  for (const type of (await send('GET', '/ResourceTypes')).body.Resources) readBy(Schemas.ResourceType, type);
  for (const { id, attributes } of (await send('GET', '/Schemas')).body.Resources) {
    const { definition } = Object.values(Schemas).find((schema) => schema.id === id);
    for (const { name, type, multiValued } of attributes) {
      const known = definition.attribute(name);
      deepStrictEqual([type, multiValued], [known.type, known.config.multiValued], `${id}: ${name}`);
      checks += 1;
    }
  }
}

async function checkUsers() {
  const emails = [{ value: 'ada@uni.example', type: 'work' }];
  let ada = await create(USERS, { userName: 'ada@uni.example', externalId: '4711', displayName: 'Ada', active: true, emails });
  ada = await patch(USERS, ada, [{ op: 'replace', path: 'displayName', value: 'Ada King' }]);
  ada = await patch(USERS, ada, [{ op: 'replace', path: 'emails[type eq "work"].value', value: 'king@uni.example' }]);
  ada = await patch(USERS, ada, [{ op: 'replace', value: { externalId: '4712', active: false } }]);
  ada = await patch(USERS, ada, [{ op: 'remove', path: 'emails' }, { op: 'add', path: 'active', value: true }]);
  ada = await patch(USERS, ada, [{ op: 'add', path: 'emails', value: emails }, { op: 'remove', path: 'externalId' }]);
  const replaced = await send('PUT', `${USERS}/${ada.id}`, { ...plain(ada), displayName: 'Ada Lovelace' });
  strictEqual(readBy(Schemas.User, replaced.body).displayName, 'Ada Lovelace');
  assertError(await send('POST', USERS, { userName: 'ADA@uni.example', displayName: 'Ada' }), 409, 'uniqueness');
  assertError(await send('POST', USERS, { displayName: 'Ada' }), 400, 'invalidValue');
  assertError(await send('GET', `${USERS}/nothing`), 404, undefined);
  assertError(await send('GET', `${USERS}?filter=userName%20is%20x`), 400, 'invalidFilter');
  const bob = await create(USERS, { userName: 'bob@uni.example', displayName: 'Bob', active: true });
  const found = await list(USERS, { filter: 'userName eq "bob@uni.example" and active eq true' });
  deepStrictEqual(found.map(({ id }) => id), [bob.id]);
  strictEqual((await list(USERS, { startIndex: 2, count: 1 })).length, 1);
  return [ada, bob];
}

async function checkGroups([ada, bob]) {
  let group = await create(GROUPS, { displayName: 'Spring', members: [{ value: ada.id }] });
  const added = await send('PATCH', `${GROUPS}/${group.id}`, new Messages.PatchOp({
    schemas: [Messages.PatchOp.id],
    Operations: [{ op: 'add', path: 'members', value: [{ value: bob.id }] }],
  }));
  group = readBy(Schemas.Group, added.body);
  deepStrictEqual(group.members.map(({ value }) => value).sort(), [ada.id, bob.id].sort());
  group = await patch(GROUPS, group, [{ op: 'remove', path: `members[value eq "${ada.id}"]` }]);
  group = await patch(GROUPS, group, [{ op: 'replace', path: 'displayName', value: 'Autumn' }]);
  deepStrictEqual((await list(GROUPS, { filter: 'displayName eq "Autumn"' })).map(({ id }) => id), [group.id]);
  strictEqual((await send('DELETE', `${GROUPS}/${group.id}`)).status, 204);
  assertError(await send('GET', `${GROUPS}/${group.id}`), 404, undefined);
  strictEqual((await send('DELETE', `${USERS}/${bob.id}`)).status, 204);
  assertError(await send('GET', `${USERS}/${bob.id}`), 404, undefined);
}

await checkDiscovery();
await checkGroups(await checkUsers());
console.log(`${checks} answers are accepted by SCIMMY`);
