// Loads a usdz or a binary glTF with three.js, says what it holds, and draws the repeat in its
// lower left corner from the front, in light from everywhere.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { USDLoader } from 'three/addons/loaders/USDLoader.js';

const SIDE = 64;

function describe(texture) {
	return texture && {
		width: texture.image?.width ?? 0,
		height: texture.image?.height ?? 0,
		repeat: texture.repeat.toArray(),
		wrap: [texture.wrapS, texture.wrapT].every((mode) => mode === THREE.RepeatWrapping),
		srgb: texture.colorSpace === THREE.SRGBColorSpace,
	};
}

function draw(scene, size, repeat) {
	const renderer = new THREE.WebGLRenderer();
	renderer.setSize(SIDE, SIDE, false);
	const camera = new THREE.OrthographicCamera(0, 1 / repeat.x, 1 / repeat.y, 0, 0.1, 10);
	camera.position.set(-size.x / 2, -size.y / 2, 1);
	scene.add(new THREE.AmbientLight(0xffffff, Math.PI));
	renderer.render(scene, camera);
	const gl = renderer.getContext();
	const pixels = new Uint8Array(4 * SIDE * SIDE);
	gl.readPixels(0, 0, SIDE, SIDE, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
	return Array.from(pixels);
}

export async function run([url]) {
	const loader = url.endsWith('.usdz') ? new USDLoader() : new GLTFLoader();
	const loaded = await loader.loadAsync(url);
	const root = loaded.scene ?? loaded;
	const meshes = [];
	root.traverse((node) => node.isMesh && meshes.push(node));
	const size = new THREE.Box3().setFromObject(root).getSize(new THREE.Vector3());
	const [mesh] = meshes;
	const uv = mesh.geometry.attributes.uv;
	const maps = {};
	for (const key of ['map', 'normalMap', 'roughnessMap', 'aoMap', 'anisotropyMap', 'alphaMap'])
		maps[key] = describe(mesh.material[key]);
	const scene = new THREE.Scene();
	scene.add(root);
	return {
		meshes: meshes.length,
		size: size.toArray(),
		uv: Array.from(uv.array),
		maps,
		material: {
			type: mesh.material.type,
			alphaTest: mesh.material.alphaTest,
			anisotropy: mesh.material.anisotropy,
			ior: mesh.material.ior,
		},
		pixels: mesh.material.map && draw(scene, size, mesh.material.map.repeat),
	};
}
