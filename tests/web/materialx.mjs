// Draws a square with every material of a MaterialX document, in linear light, its first row below.
//
// The square reaches from -1 to 1 and is seen from (0, 0, 2), which it fills; one light shines from
// +z. The second file is JSON: the extent `st` of the texture coordinates and the `size` in pixels.
import * as THREE from 'three/webgpu';
import { MaterialXLoader } from 'three/addons/loaders/MaterialXLoader.js';

function square(st) {
	const geometry = new THREE.PlaneGeometry(2, 2);
	const uv = geometry.attributes.uv;
	for (let i = 0; i < uv.count; i++) uv.setXY(i, uv.getX(i) * st[0], uv.getY(i) * st[1]);
	geometry.computeTangents();
	return geometry;
}

async function draw(renderer, material, geometry, size) {
	const scene = new THREE.Scene();
	scene.add(new THREE.Mesh(geometry, material));
	const light = new THREE.DirectionalLight(0xffffff, 1);
	light.position.set(0, 0, 1);
	scene.add(light);
	const camera = new THREE.PerspectiveCamera(2 * Math.atan(0.5) * 180 / Math.PI, 1, 0.1, 10);
	camera.position.z = 2;
	const target = new THREE.RenderTarget(size, size, { type: THREE.FloatType });
	renderer.setRenderTarget(target);
	renderer.render(scene, camera);
	return Array.from(await renderer.readRenderTargetPixelsAsync(target, 0, 0, size, size));
}

export async function run([document, settings]) {
	const { st, size } = await (await fetch(settings)).json();
	const renderer = new THREE.WebGPURenderer({ forceWebGL: true });
	await renderer.init();
	// The loader puts an image's first row at v = 0 unless it is told that this is the top.
	const { materials, warnings } = await new MaterialXLoader().loadAsync(document, { uvSpace: 'top-left' });
	const geometry = square(st);
	const pictures = {};
	for (const [name, material] of Object.entries(materials))
		pictures[name] = await draw(renderer, material, geometry, size);
	return { pictures, warnings: warnings.map((warning) => warning.message) };
}
