import { THREE } from "nicegui-scene";

export default class Points {
  create_mesh(points, size, on_top) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(points.flat(), 3));
    const mesh = new THREE.Points(geometry, new THREE.PointsMaterial({ size, transparent: true, depthTest: !on_top }));
    mesh.renderOrder = on_top ? 3 : 0;
    return mesh;
  }
}
