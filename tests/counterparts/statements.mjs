// Judges statements of xAPI 1.0.3 by the validator of Learning Locker: one JSON document on each line of standard input. Prints how many
// have warnings, and the first of them; ends with status 1 if there are any, or no statement at all.
//
//   statements.mjs FOLDER
//
// FOLDER has @learninglocker/xapi-validation in its node_modules.
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { argv, exit, stdin } from 'node:process';
import { createInterface } from 'node:readline';

const { default: validate } = createRequire(join(argv[2], 'package.json'))('@learninglocker/xapi-validation');
const MOST_SHOWN = 10;
let statements = 0;
let warned = 0;

/** A warning in words: its kind, and where in the statement it is. */
function describe(warning) {
  return `${warning.constructor.name} at ${warning.path.join('.')}`;
}

for await (const line of createInterface({ input: stdin })) {
  if (!line.trim()) continue;
  statements += 1;
  const warnings = validate(JSON.parse(line));
  if (!warnings.length) continue;
  warned += 1;
  if (warned <= MOST_SHOWN) console.error(`statement ${statements}: ${warnings.map(describe).join(', ')}`);
}
console.log(`${warned} of ${statements} statements have warnings`);
exit(warned || !statements ? 1 : 0);
