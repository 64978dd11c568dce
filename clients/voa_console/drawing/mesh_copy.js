import { apply_material, STLLoader, THREE } from "nicegui-scene";

const loader = new STLLoader();
const geometries = new Map(); // of each address: all copies of a mesh share its triangles

function geometry_at(url) {
  if (!geometries.has(url)) {
    const loading = loader.loadAsync(url);
    loading.catch(() => geometries.delete(url));
    geometries.set(url, loading);
  }
  return geometries.get(url);
}

export default class MeshCopy {
  async create_mesh(url) {
    const material = new THREE.MeshLambertMaterial({ transparent: true });
    this.mesh = new THREE.Mesh(await geometry_at(url), material);
    return this.mesh;
  }
  apply_material(material) {
    apply_material(this.mesh.material, material);
    // A ghost must not hide the ghosts behind it.
    this.mesh.material.depthWrite = material.opacity >= 1;
    this.mesh.renderOrder = material.opacity;
    // Otherwise each ghost is drawn twice, once for each side of its faces.
    this.mesh.material.forceSinglePass = true;
  }
}
