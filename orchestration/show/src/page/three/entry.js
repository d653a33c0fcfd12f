export {
  BufferAttribute, BufferGeometry, Color, DataTexture, DoubleSide, EqualStencilFunc, GLSL3,
  InstancedBufferAttribute, InstancedBufferGeometry, KeepStencilOp, LinearFilter, LinearSRGBColorSpace,
  LineSegments, Mesh, PerspectiveCamera, RawShaderMaterial, ReplaceStencilOp, Scene, Vector3, WebGLRenderer,
} from 'three';
export { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
