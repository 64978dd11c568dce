import { THREE } from "nicegui-scene";

export default class Polyline {
  create_mesh(points, closed, on_top) {
    const geometry = new THREE.BufferGeometry().setFromPoints(points.map((point) => new THREE.Vector3(...point)));
    const material = new THREE.LineBasicMaterial({ transparent: true, depthTest: !on_top });
    const mesh = closed ? new THREE.LineLoop(geometry, material) : new THREE.Line(geometry, material);
    mesh.renderOrder = on_top ? 2 : 0;
    return mesh;
  }
}
