// Runs a module of this folder in headless Chromium and prints what it returns as JSON.
//
//   node page.mjs BROWSER MODULE FILE…
//
// MODULE exports `run(urls)`, `urls` being those of the files, which find what lies beside them;
// bare imports of three work.
import { createServer } from 'node:http';
import { readFileSync } from 'node:fs';
import { dirname, extname, join } from 'node:path';
import puppeteer from 'puppeteer-core';

const [executablePath, module, ...files] = process.argv.slice(2);
const here = import.meta.dirname;
const types = { '.js': 'text/javascript', '.mjs': 'text/javascript', '.html': 'text/html' };
const page = `<!doctype html><script type="importmap">{"imports": {
	"three": "/node_modules/three/build/three.module.js",
	"three/webgpu": "/node_modules/three/build/three.webgpu.js",
	"three/tsl": "/node_modules/three/build/three.tsl.js",
	"three/addons/": "/node_modules/three/examples/jsm/"}}</script>`;

const server = createServer((request, response) => {
	const path = new URL(request.url, 'http://localhost').pathname;
	try {
		const [, index, name] = path.match(/^\/files\/(\d+)\/(.*)/) ?? [];
		const named = index && (name.startsWith('cloth.') ? files[index] : join(dirname(files[index]), name));
		const body = path === '/' ? page : readFileSync(named ?? join(here, path));
		response.writeHead(200, { 'Content-Type': types[extname(path) || '.html'] ?? 'application/octet-stream' });
		response.end(body);
	} catch {
		response.writeHead(404);
		response.end();
	}
});
await new Promise((done) => server.listen(0, '127.0.0.1', done));

const browser = await puppeteer.launch({
	executablePath,
	args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
try {
	const tab = await browser.newPage();
	const complaints = [];
	tab.on('console', (message) => {
		if (['error', 'warn'].includes(message.type())) complaints.push(message.text());
	});
	tab.on('pageerror', (error) => complaints.push(String(error)));
	await tab.goto(`http://127.0.0.1:${server.address().port}/`);
	const urls = files.map((file, index) => `/files/${index}/cloth${extname(file)}`);
	const result = await tab.evaluate(
		async (name, list) => (await import(`/${name}`)).run(list), module, urls);
	process.stdout.write(JSON.stringify({ result, complaints }));
} finally {
	await browser.close();
	server.close();
}
