// node validate.mjs BEFORE AFTER: fails where the Khronos validator finds more errors or warnings of a kind in AFTER. An OBJ has none.
import fs from 'fs';
import path from 'path';
import { createRequire } from 'module';

const validator = createRequire(path.resolve(process.env.NODE_HOME) + '/')('gltf-validator');

/** How many errors and warnings of each kind there are, and where the first of each is. */
async function findings(file) {
    if (!/\.gl(b|tf)$/i.test(file)) return new Map();
    const read = (uri) => new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri))));
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
        uri: path.basename(file),
        maxIssues: 0,
        externalResourceFunction: async (uri) => read(uri),
    });
    const kinds = new Map();
    for (const { code, severity, pointer, message } of report.issues.messages.filter((m) => m.severity < 2)) {
        const kind = kinds.get(code) ?? { count: 0, severity, first: `${pointer}: ${message}` };
        kinds.set(code, { ...kind, count: kind.count + 1 });
    }
    return kinds;
}

const [before, after] = await Promise.all(process.argv.slice(2, 4).map(findings));
for (const [code, { count, severity, first }] of after) {
    const old = before.get(code)?.count ?? 0;
    if (count > old) {
        console.log(`${['error', 'warning'][severity]}: ${code}: ${count}, before ${old}; ${first}`);
        process.exitCode = 1;
    }
}
