// Prints what Khronos' validator says of each binary glTF named: node gltf.mjs FILE…
import { readFileSync } from 'node:fs';
import validator from 'gltf-validator';

const reports = [];
for (const file of process.argv.slice(2)) {
	const report = await validator.validateBytes(new Uint8Array(readFileSync(file)));
	reports.push({ ...report.issues, info: report.info });
}
process.stdout.write(JSON.stringify(reports));
