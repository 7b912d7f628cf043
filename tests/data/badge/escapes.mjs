// Writes escapes.nq: each character below U+0080, escaped as RDFC-1.0 requires.
//
//   npm install rdf-canonize@5.0.0
//   node escapes.mjs FOLDER     FOLDER has rdf-canonize in its node_modules
import { writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { argv } from 'node:process';

const { canonize } = createRequire(join(argv[2], 'package.json'))('rdf-canonize');
const string = { termType: 'NamedNode', value: 'http://www.w3.org/2001/XMLSchema#string' };
const dataset = Array.from({ length: 0x80 }, (_, code) => ({
  subject: { termType: 'NamedNode', value: `urn:x:${String(code).padStart(3, '0')}` },
  predicate: { termType: 'NamedNode', value: 'https://schema.org/name' },
  object: { termType: 'Literal', value: String.fromCharCode(code), datatype: string },
  graph: { termType: 'DefaultGraph', value: '' },
}));
writeFileSync(new URL('escapes.nq', import.meta.url), await canonize(dataset, { algorithm: 'RDFC-1.0' }));
