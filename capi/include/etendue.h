/*
 * Etendue, a Monte Carlo renderer, as a C library. Made by `make header` from the sources in capi/; docs/c-api.md is the guide.
 *
 * Every function may be called from any thread. Structures begin with their own size, struct_size, which callers set; zeros in
 * all other fields stand for defaults. What a structure points to is copied during the call, unless it says otherwise. Handles
 * are held by whoever created or retained them until they are released.
 */

#ifndef ETENDUE_H
#define ETENDUE_H

#include <stddef.h>
#include <stdint.h>

// `EtdSettings.flags`: `seed` is given.
#define ETD_HAS_SEED 1

// `EtdSettings.flags`: `max_bounces` is given.
#define ETD_HAS_MAX_BOUNCES 2

// `EtdSettings.flags`: render layers, which can be read and written besides the image. The sample count is rounded up
// to a multiple of 4.
#define ETD_LAYERS 4

// `EtdSettings.flags`: `crop` is given.
#define ETD_HAS_CROP 8

// The result of a call. All values but `ETD_STATUS_OK` and `ETD_STATUS_CANCELLED` are failures: the call has changed
// nothing, unless stated otherwise, and the message is stored with the handle that was passed.
typedef enum {
  // Success.
  ETD_STATUS_OK = 0,
  // Cancelled on request; the samples so far are kept.
  ETD_STATUS_CANCELLED = 1,
  // An argument is null, out of range, or inconsistent with the others.
  ETD_STATUS_INVALID_ARGUMENT = 2,
  // The handle is null, was released, or does not belong to this library.
  ETD_STATUS_INVALID_HANDLE = 3,
  // The scene, a part of it, or a file that it refers to, is invalid.
  ETD_STATUS_INVALID_SCENE = 4,
  // A file could not be read or written.
  ETD_STATUS_INPUT_OUTPUT = 5,
  // The ray tracing library, or the rendering itself, failed.
  ETD_STATUS_RENDER_FAILED = 6,
  // There is not enough memory.
  ETD_STATUS_OUT_OF_MEMORY = 7,
  // The handle is in use by another call that excludes this one, such as a running render.
  ETD_STATUS_BUSY = 8,
  // The scene has not been committed.
  ETD_STATUS_NOT_COMMITTED = 9,
  // A bug in the library, which should be reported. The handle should be released.
  ETD_STATUS_INTERNAL = 10,
} EtdStatus;

// The ray tracing libraries.
typedef enum {
  // The default backend of this build.
  ETD_BACKEND_DEFAULT = 0,
  // Intel Embree.
  ETD_BACKEND_EMBREE = 1,
  // obvhs with two children per node.
  ETD_BACKEND_OBVHS_BVH2 = 2,
  // obvhs with eight children per node.
  ETD_BACKEND_OBVHS_CWBVH = 3,
} EtdBackend;

// Reconstruction filters.
typedef enum {
  // Gaussian filter.
  ETD_FILTER_GAUSSIAN = 0,
  // Box filter: constant weight.
  ETD_FILTER_BOX = 1,
  // Tent (triangle) filter.
  ETD_FILTER_TENT = 2,
  // Mitchell-Netravali filter, with negative lobes.
  ETD_FILTER_MITCHELL = 3,
  // Blackman-Harris filter.
  ETD_FILTER_BLACKMAN_HARRIS = 4,
} EtdFilter;

// Number formats.
typedef enum {
  // 32-bit floats.
  ETD_FORMAT_FLOAT32 = 0,
  // 64-bit floats.
  ETD_FORMAT_FLOAT64 = 1,
} EtdFormat;

// Kinds of lights that are not shapes.
typedef enum {
  // Environment light from infinity in all directions: `value` as radiance, or `panorama`; `transform`.
  ETD_LIGHT_KIND_ENVIRONMENT = 0,
  // Point light: `value` as intensity, `position`.
  ETD_LIGHT_KIND_POINT = 1,
  // Spot light, which emits into a cone: as a point light, with `target`, `cone`, `penumbra`.
  ETD_LIGHT_KIND_SPOT = 2,
  // Distant light, parallel: `value` as irradiance, `direction`.
  ETD_LIGHT_KIND_DISTANT = 3,
} EtdLightKind;

// Scattering models.
typedef enum {
  // Lambertian reflection: `color`.
  ETD_MODEL_DIFFUSE = 0,
  // A perfect mirror: `color`.
  ETD_MODEL_MIRROR = 1,
  // Metal with a complex refractive index: `eta`, `k`, `roughness`.
  ETD_MODEL_CONDUCTOR = 2,
  // A dielectric such as glass or water: `ior`, `roughness`, and `color` as the tint of refracted light.
  ETD_MODEL_DIELECTRIC = 3,
  // A specular lobe over a diffuse one: `color`, `specular`, `exponent`.
  ETD_MODEL_PHONG = 4,
  // A diffuse base under a dielectric coat: `color`, `ior`, `roughness`.
  ETD_MODEL_PLASTIC = 5,
  // The metallic-roughness model: `color`, `metallic`, `roughness`, `ior`, `transmission`.
  ETD_MODEL_PRINCIPLED = 6,
  // A smooth pane of a dielectric: `ior`, and `color` as the tint of transmitted light.
  ETD_MODEL_THIN_DIELECTRIC = 7,
} EtdModel;

// Precision of ray intersection.
typedef enum {
  // Watertight at edges.
  ETD_PRECISION_ROBUST = 0,
  // About a third faster; may miss hits at edges.
  ETD_PRECISION_FAST = 1,
} EtdPrecision;

// A render of a scene, with its samples so far.
typedef struct EtdRender EtdRender;

// A scene.
typedef struct EtdScene EtdScene;

// An image in the caller's memory, which is copied.
typedef struct {
  // sizeof(EtdImage)
  size_t struct_size;
  // Width in pixels.
  uint32_t width;
  // Height in pixels.
  uint32_t height;
  // Red, green and blue of each pixel, linear Rec. 709, row by row from the top.
  const float *rgb;
  // Bytes from one pixel to the next; 0 stands for three floats without a gap.
  size_t pixel_stride;
  // Factor for every value; 0 stands for 1.
  float scale;
} EtdImage;

// A material. Fields that are not listed at its model are ignored; sides, alpha and normals apply to every model.
typedef struct {
  // sizeof(EtdMaterial)
  size_t struct_size;
  // Name for messages; may be null.
  const char *name;
  // An `EtdModel`.
  int32_t model;
  // Reflectance or tint, from 0 to 1 in each channel.
  float color[3];
  // Replaces `color`, indexed by the texture coordinates of the shape; null for none.
  const EtdImage *texture;
  // Albedo of the specular lobe; at most 1 when added to `color`.
  float specular[3];
  // Exponent of the cosine of the specular lobe, up to 1e6.
  float exponent;
  // Roughness, from 0 (smooth) to 1.
  float roughness;
  // Refractive index, inside over outside; 0 stands for 1.5.
  float ior;
  // Metalness, from 0 to 1.
  float metallic;
  // Transmission, from 0 to 1.
  float transmission;
  // Real part of a metal's refractive index, above 0.
  float eta[3];
  // Imaginary part of a metal's refractive index.
  float k[3];
  // Other than 0: the back absorbs everything.
  uint32_t one_sided;
  // Replaces `alpha`, indexed by the texture coordinates of the shape: the luminance of each pixel, from 0 to 1, is
  // used; null for none.
  const EtdImage *alpha_texture;
  // Replaces `specular`, indexed by the texture coordinates of the shape; null for none.
  const EtdImage *specular_texture;
  // A normal map, indexed by the texture coordinates of the shape: red is along u, green along v, blue away from the
  // surface, each mapped from [-1, 1] to [0, 1]; null for none.
  const EtdImage *normal_map;
  // Factor for red and green of the normals; 0 stands for 1.
  float normal_strength;
  // Coverage of the surface (opacity), up to 1; light passes straight through the rest. 0 stands for 1.
  float alpha;
  // A bump map, indexed by the texture coordinates of the shape: the luminance of each pixel, from 0 to 1 or beyond, is a
  // height; null for none, as beside `normal_map`.
  const EtdImage *bump_map;
  // The height of a value of 1, in world units; below 0, bumps become dents.
  float bump_height;
  // The fraction of the surface under a clear coat, from 0 (none) to 1, of a conductor or of a principled material
  // without transmission.
  float clear_coat;
  // Roughness of the clear coat, from 0 (smooth) to 1.
  float clear_coat_roughness;
  // Refractive index of the clear coat, at least 1; 0 stands for 1.5.
  float clear_coat_ior;
} EtdMaterial;

// A keyframe of a shape or an instance. Between two keyframes, translation and scale are interpolated linearly, and
// rotations at constant speed, the shorter way; before the first and after the last one, the transform is constant.
typedef struct {
  // The time, in the unit of the camera's shutter; later than that of the previous keyframe.
  double time;
  // The transform that is applied after the object's own `transform`: 12 numbers, row by row.
  double transform[12];
} EtdKey;

// Attributes of a shape besides its geometry.
typedef struct {
  // sizeof(EtdSurface)
  size_t struct_size;
  // Name for messages; may be null.
  const char *name;
  // The material, as numbered by `etd_scene_add_material`.
  uint32_t material;
  // The group that contains the shape, as numbered by `etd_scene_add_group`; 0 for the world itself.
  uint32_t group;
  // Emitted radiance; the shape does not emit if all are zero.
  float emission[3];
  // Other than 0: both sides emit; 0: only the side of the geometric normal.
  uint32_t two_sided_emission;
  // Shape to world, or to its group: the three upper rows of a matrix, row by row, 12 numbers; null for the identity.
  const double *transform;
  // Replaces `emission`, indexed by the texture coordinates of the shape; null for none.
  const EtdImage *emission_texture;
  // Keyframes; null for a static shape. The shape moves while the camera's shutter is open.
  const EtdKey *motion;
  // Number of keyframes, which are in order of time.
  size_t motion_count;
  // Bytes from one keyframe to the next; 0 stands for no gap.
  size_t motion_stride;
} EtdSurface;

// A triangle mesh in the caller's memory, which is copied. Strides are bytes from one item to the next; 0 stands for
// items without a gap. Addresses need no alignment.
typedef struct {
  // sizeof(EtdMesh)
  size_t struct_size;
  // x, y and z of each vertex.
  const void *positions;
  // Number of vertices, below 2^32.
  size_t vertex_count;
  // Bytes from one position to the next.
  size_t position_stride;
  // An `EtdFormat`, of positions only: all other attributes are 32-bit floats.
  int32_t position_format;
  // Shading normals, one per vertex, of any length; null for none.
  const float *normals;
  // Bytes from one normal to the next.
  size_t normal_stride;
  // Texture coordinates u and v, one pair per vertex, v up; null for none.
  const float *uvs;
  // Bytes from one texture coordinate to the next.
  size_t uv_stride;
  // Three vertex indices per triangle; the geometric normal is (b - a) x (c - a).
  const uint32_t *indices;
  // Number of triangles, below 2^32.
  size_t triangle_count;
  // Bytes from one triangle to the next.
  size_t index_stride;
} EtdMesh;

// An instance of a group.
typedef struct {
  // sizeof(EtdInstance)
  size_t struct_size;
  // Name for messages; may be null.
  const char *name;
  // The instanced group, as numbered by `etd_scene_add_group`.
  uint32_t of;
  // The group that contains the instance; 0 for the world itself.
  uint32_t group;
  // Group to world, or to the group that contains the instance: 12 numbers, row by row; null for the identity.
  const double *transform;
  // Keyframes; null for a static instance. The instance moves while the camera's shutter is open.
  const EtdKey *motion;
  // Number of keyframes, which are in order of time.
  size_t motion_count;
  // Bytes from one keyframe to the next; 0 stands for no gap.
  size_t motion_stride;
} EtdInstance;

// A light that is not a shape. Fields that are not listed at its kind are ignored.
typedef struct {
  // sizeof(EtdLight)
  size_t struct_size;
  // An `EtdLightKind`.
  int32_t kind;
  // Radiance, intensity or irradiance, at least 0.
  float value[3];
  // Environment map, replaces `value`: its middle is seen along -z, its right half towards +x, its top along +y; null
  // for none.
  const EtdImage *panorama;
  // Position of a point or spot light.
  double position[3];
  // The point at which a spot light is aimed.
  double target[3];
  // Direction in which the light of a distant light travels.
  double direction[3];
  // Angle from the axis of a spot light to its edge in degrees, up to 180.
  double cone;
  // The outer part of the cone angle over which the intensity falls off, in degrees.
  double penumbra;
  // Rotation from the axes of the panorama to world axes: 12 numbers, row by row; null for the identity.
  const double *transform;
} EtdLight;

// A ray in world space.
typedef struct {
  // Origin.
  double origin[3];
  // Direction, of any length but 0.
  double direction[3];
  // Hits at this distance or nearer are ignored.
  double min_distance;
  // Hits beyond this distance are ignored; 0 stands for any distance.
  double max_distance;
  // The time, from 0, when the shutter opens, to 1.
  double time;
} EtdRay;

// The closest hit of a ray.
typedef struct {
  // 1 for a hit, 0 for a miss; on a miss, all other fields are 0.
  uint32_t met;
  // The shape's number.
  uint32_t shape;
  // Index of the primitive in the shape, not counting those without area.
  uint32_t primitive;
  // Reserved; 0.
  uint32_t reserved;
  // Distance from the origin.
  double distance;
  // Position.
  double position[3];
  // Geometric normal of unit length, on the front of the shape.
  double normal[3];
  // Shading normal: towards the ray, or outwards on transmissive materials.
  double shading_normal[3];
  // Texture coordinates; 0 if no texture of the shape uses them.
  double uv[2];
} EtdHit;

// Settings of a render. Zeros and null stand for the settings of the scene, and then for the defaults.
typedef struct {
  // sizeof(EtdSettings)
  size_t struct_size;
  // A sum of flags such as `ETD_HAS_SEED`.
  uint32_t flags;
  // Maximum number of scattering events, with `ETD_HAS_MAX_BOUNCES`; `UINT32_MAX` for no limit. A limit causes bias.
  uint32_t max_bounces;
  // Samples per pixel.
  uint64_t spp;
  // Maximum time in seconds.
  double seconds;
  // Target error, the square root of relMSE, such as 0.01.
  double error;
  // Confidence level of the target error; 0 stands for 0.95.
  double confidence;
  // Seed, which selects one of 2^64 sets of random numbers, with `ETD_HAS_SEED`.
  uint64_t seed;
  // The integrator, such as "path" or "ambient-occlusion".
  const char *integrator;
  // The sampler: "sobol", "stratified" or "independent".
  const char *sampler;
  // Adaptive sampling: "off", "two-phase" or "greedy".
  const char *adaptive;
  // Russian roulette: "none", "albedo", "throughput", "window", or "window=1/N" with N from 1 to 64.
  const char *roulette;
  // Maximum distance, in world units, of occluders for ambient occlusion.
  double occlusion_distance;
  // Admissible relative error of "irradiance-cache", as a fraction of the indirect light, such as 0.05; below 1.
  double cache_error;
  // With `ETD_HAS_CROP`, x0, y0, x1, y1: only the pixels from (x0, y0) up to but not including (x1, y1) are rendered.
  uint32_t crop[4];
  // Light paths for each camera path of "path": "auto", "off", "1/4", "1/2", "1" or "2"; with "caustics:" before a
  // number, they are connected to the lens beyond glossy and smooth surfaces only.
  const char *light_paths;
  // Estimator of the filter: "splatting" or "importance".
  const char *filter_sampling;
  // Pixels that share the paths of "path": "auto", "off", "4" or "16".
  const char *reuse;
} EtdSettings;

// Progress of a render.
typedef struct {
  // Size of this structure in bytes.
  size_t struct_size;
  // Samples so far, over all pixels.
  uint64_t samples;
  // Completed samples per pixel; their mean if pixels differ.
  uint64_t spp;
  // Seconds since the call began.
  double seconds;
  // Completed fraction of the budget, from 0 to 1.
  double fraction;
  // Estimated error so far, the square root of relMSE; NaN while it cannot be estimated.
  double rel_rmse;
} EtdProgress;

// An intermediate image of a render, valid only during the callback.
typedef struct {
  // Size of this structure in bytes.
  size_t struct_size;
  // Width in pixels.
  uint32_t width;
  // Height in pixels.
  uint32_t height;
  // Red, green and blue of each pixel, linear Rec. 709, row by row from the top without a gap.
  const float *rgb;
} EtdPicture;

// Callbacks that observe a render. Any of them may be null. They may not throw, longjmp, or wait for the render that
// calls them. They may call this library; calls that the running render excludes return `ETD_STATUS_BUSY`.
typedef struct {
  // sizeof(EtdWatch)
  size_t struct_size;
  // Passed to each function.
  void *user;
  // Called often, from any of the render's threads and from several at once. A result other than 0 ends the render as
  // soon as possible; the samples so far are kept. `progress` is valid only during the call. While "irradiance-cache"
  // fills its cache, before the first sample, there are 0 samples.
  int32_t (*progress)(void *user, const EtdProgress *progress);
  // Called after each pass over the image, from one of the render's threads while the others wait.
  void (*picture)(void *user, const EtdPicture *picture);
} EtdWatch;

// Statistics and error estimates of a render.
typedef struct {
  // sizeof(EtdRenderInfo), to be set before the call.
  size_t struct_size;
  // Width in pixels of the rendered window.
  uint32_t width;
  // Height in pixels of the rendered window.
  uint32_t height;
  // Completed samples per pixel; their mean if pixels differ.
  uint64_t spp;
  // Total number of samples over all pixels.
  uint64_t samples;
  // Number of rays traced.
  uint64_t rays;
  // Number of samples that were not finite, and were rejected.
  uint64_t rejected;
  // Rendering time so far, in seconds.
  double seconds;
  // 1 if the last call was cancelled.
  uint32_t cancelled;
  // 1 if the last call ended because the target error was reached.
  uint32_t reached;
  // Estimated error, the square root of relMSE; NaN with fewer than four samples per pixel.
  double rel_rmse;
  // Upper bound of the error at this `confidence`; NaN while it cannot be estimated, infinite if rare bright paths
  // cause so much of the error that the samples give no bound.
  double rel_rmse_upper;
  // Confidence level of the upper bound.
  double confidence;
  // Fraction of pixels whose error bars are not reliable.
  double uncalibrated_fraction;
  // Lower bound of the error if there is no upper bound; otherwise 0.
  double rel_rmse_at_least;
} EtdRenderInfo;

// A keyframe of a camera.
typedef struct {
  // The time; later than that of the previous keyframe.
  double time;
  // Position of the camera.
  double eye[3];
  // The point that the camera looks at.
  double target[3];
  // The up direction; all zeros stand for y.
  double up[3];
} EtdCameraKey;

// A perspective camera.
typedef struct {
  // sizeof(EtdCamera)
  size_t struct_size;
  // Position of the camera.
  double eye[3];
  // The point that the camera looks at.
  double target[3];
  // The up direction; all zeros stand for y.
  double up[3];
  // Vertical field of view in degrees, below 180; 0 stands for 40.
  double fov;
  // Radius of the lens; 0 is a pinhole.
  double lens_radius;
  // Distance of the plane of focus; 0 stands for that of the target, which is that of the first keyframe if the
  // camera moves.
  double focus_distance;
  // Two times: when the shutter opens and when it closes, in the unit of all keyframes. If they are equal, everything
  // is static at that time. Null leaves the shutter unchanged; that of a new scene is { 0, 0 }.
  const double *shutter;
  // Keyframes, which replace `eye`, `target` and `up`; null for a static camera.
  const EtdCameraKey *motion;
  // Number of keyframes, which are in order of time.
  size_t motion_count;
  // Bytes from one keyframe to the next; 0 stands for no gap.
  size_t motion_stride;
} EtdCamera;

// The film.
typedef struct {
  // sizeof(EtdFilm)
  size_t struct_size;
  // Width in pixels, from 1 to 65536.
  uint32_t width;
  // Height in pixels, from 1 to 65536.
  uint32_t height;
  // The reconstruction filter, an `EtdFilter`.
  int32_t filter;
  // The filter radius in pixels, up to 32; 0 stands for the filter's default.
  double filter_radius;
} EtdFilm;

// Options of ray tracing. Zeros stand for the defaults.
typedef struct {
  // sizeof(EtdTracing)
  size_t struct_size;
  // An `EtdBackend`.
  int32_t backend;
  // An `EtdPrecision`.
  int32_t precision;
  // Threads that build and render; 0 stands for all threads available to the process.
  uint32_t threads;
} EtdTracing;

// Statistics about preparing a scene.
typedef struct {
  // sizeof(EtdWork), to be set before the call.
  size_t struct_size;
  // Number of full builds since the last commit, including all acceleration structures: 1 after it, plus 1 for each
  // change that requires a full build.
  uint64_t builds;
  // Number of updates of instances, in which only the top-level structure was built.
  uint64_t placements;
  // Number of updates of the camera or the film, in which nothing was built.
  uint64_t cameras;
  // Seconds that the last of these operations took.
  double seconds;
} EtdWork;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Adds a material and writes its number, counted from 0, unless `number` is null. Textures are copied.
//
// Pointers:
// `material` is null, or a structure of its `struct_size`, whose pointers are null or valid.
EtdStatus etd_scene_add_material(EtdScene *scene,
                                 const EtdMaterial *material,
                                 uint32_t *number);

// Adds a triangle mesh and writes the number of the shape, counted from 0, unless `number` is null. All buffers are
// copied.
//
// Pointers:
// `surface` and `mesh` are null, or structures of their `struct_size`, whose pointers are null or valid.
EtdStatus etd_scene_add_mesh(EtdScene *scene,
                             const EtdSurface *surface,
                             const EtdMesh *mesh,
                             uint32_t *number);

// Adds a sphere around `center`, three numbers, and writes the number of the shape unless `number` is null.
//
// Pointers:
// As `etd_scene_add_mesh`; `center` is null, or three numbers.
EtdStatus etd_scene_add_sphere(EtdScene *scene,
                               const EtdSurface *surface,
                               const double *center,
                               double radius,
                               uint32_t *number);

// Adds a disk around `center`, with a normal of any length, and writes the number of the shape unless `number` is null.
//
// Pointers:
// As `etd_scene_add_sphere`; likewise for `normal`.
EtdStatus etd_scene_add_disk(EtdScene *scene,
                             const EtdSurface *surface,
                             const double *center,
                             const double *normal,
                             double radius,
                             uint32_t *number);

// Adds a parallelogram with the normal edge_u x edge_v, and writes the number of the shape unless `number` is null.
//
// Pointers:
// As `etd_scene_add_sphere`; likewise for the corner and the edges.
EtdStatus etd_scene_add_rectangle(EtdScene *scene,
                                  const EtdSurface *surface,
                                  const double *corner,
                                  const double *edge_u,
                                  const double *edge_v,
                                  uint32_t *number);

// Adds an axis-aligned box whose normals point outwards, and writes the number of the shape unless `number` is null.
//
// Pointers:
// As `etd_scene_add_sphere`; likewise for both corners.
EtdStatus etd_scene_add_box(EtdScene *scene,
                            const EtdSurface *surface,
                            const double *min,
                            const double *max,
                            uint32_t *number);

// Adds an empty group and writes its number, counted from 1: 0 stands for the world itself. `name` is for messages and
// may be null.
//
// Pointers:
// `name` is null, or a NUL-terminated string; `number` is null, or may be written.
EtdStatus etd_scene_add_group(EtdScene *scene,
                              const char *name,
                              uint32_t *number);

// Adds an instance of a group and writes its number, counted from 0, unless `number` is null.
//
// Pointers:
// `instance` is null, or a structure of its `struct_size`, whose pointers are null or valid.
EtdStatus etd_scene_add_instance(EtdScene *scene, const EtdInstance *instance, uint32_t *number);

// Adds a light that is not a shape. Its environment map is copied; a scene has at most one.
//
// Pointers:
// `light` is null, or a structure of its `struct_size`, whose pointers are null or valid.
EtdStatus etd_scene_add_light(EtdScene *scene, const EtdLight *light);

// Finds the closest hit of each of `count` rays. Strides are bytes from one item to the next; 0 stands for items
// without a gap. May be called from any number of threads at once. A surface with alpha is hit where alpha is above one
// half.
//
// Pointers:
// The pointers are null, or `count` rays may be read, and `count` hits may be written.
EtdStatus etd_scene_intersect(const EtdScene *scene,
                              const EtdRay *rays,
                              size_t count,
                              size_t ray_stride,
                              EtdHit *hits,
                              size_t hit_stride);

// Tests each of `count` rays for occlusion: writes 1 or 0 for each, without a gap. May be called from any number of
// threads at once.
//
// Pointers:
// The pointers are null, or `count` rays may be read, and `count` bytes may be written.
EtdStatus etd_scene_occluded(const EtdScene *scene,
                             const EtdRay *rays,
                             size_t count,
                             size_t ray_stride,
                             uint8_t *occluded);

// Estimates the incident radiance at the origin of each of `count` rays with `spp` samples, on the scene's threads:
// red, green and blue for each ray, without a gap. If `standard_errors` is not null, their standard errors are written,
// too, and `spp` is rounded up to a multiple of 4. Limits, crop, the flag for layers, `adaptive`, `light_paths` and
// `reuse` in `settings`, which may be null, are ignored.
//
// Pointers:
// The pointers are null, or valid; three floats for each ray may be written to the last two.
EtdStatus etd_scene_radiance(const EtdScene *scene,
                             const EtdSettings *settings,
                             const EtdRay *rays,
                             size_t count,
                             size_t ray_stride,
                             uint64_t spp,
                             float *radiance,
                             float *standard_errors);

// Copies the image to `pixels`, where `size` bytes may be written: red, green and blue of each pixel as three floats,
// linear Rec. 709, row by row from the top. Strides are bytes from one pixel or row to the next; 0 stands for no gap.
//
// Pointers:
// `pixels` is null, or `size` bytes may be written.
EtdStatus etd_render_read_pixels(const EtdRender *render,
                                 float *pixels,
                                 size_t size,
                                 size_t pixel_stride,
                                 size_t row_stride);

// Copies the standard error of each pixel, like `etd_render_read_pixels`; requires at least four samples per pixel. The
// 95 % confidence interval is two standard errors to either side; for other levels, the layer "freedom.Y" holds the
// degrees of freedom of Student's t, scaled to variance 1.
//
// Pointers:
// As `etd_render_read_pixels`.
EtdStatus etd_render_read_standard_errors(const EtdRender *render,
                                          float *pixels,
                                          size_t size,
                                          size_t pixel_stride,
                                          size_t row_stride);

// Copies a layer, one float per pixel, like `etd_render_read_pixels`; its name is one of those of docs/accuracy.md,
// such as "albedo.R", "depth.Z" or "spp.Y". For renders with `ETD_LAYERS`. First hits are traced when a layer is read
// for the first time.
//
// Pointers:
// As `etd_render_read_pixels`; `name` is null, or a NUL-terminated string.
EtdStatus etd_render_read_layer(const EtdRender *render,
                                const char *name,
                                float *pixels,
                                size_t size,
                                size_t pixel_stride,
                                size_t row_stride);

// Writes the image to a file, completely or not at all: `.exr`, with all layers if the render has them, `.png`, `.hdr`
// or `.pfm`.
//
// Pointers:
// `path` is null, or a NUL-terminated string.
EtdStatus etd_render_write(const EtdRender *render,
                           const char *path);

// Creates a render of a committed scene, without samples, and writes its handle, to be released by
// `etd_render_release`. It keeps the scene alive. `settings` may be null. The message of a failure is stored with the
// scene.
//
// Small pilots, which take up to a few seconds on the scene's threads and cannot be cancelled, choose the integrator in
// place of "auto", and for "path" what `light_paths`, `reuse` and `roulette` leave open. There are none for any other
// integrator, nor for "path" with, say, "off", "off" and "window=1/3".
//
// Pointers:
// `settings` is null, or a structure of its `struct_size`, whose pointers are null or NUL-terminated strings; `render`
// is null, or a handle may be written there.
EtdStatus etd_render_create(const EtdScene *scene,
                            const EtdSettings *settings,
                            EtdRender **render);

// Increments the reference count of a render.
EtdStatus etd_render_retain(const EtdRender *render);

// Decrements the reference count of a render, which is freed at 0, once it does not run. Null, and handles that were
// freed already, are `ETD_STATUS_INVALID_HANDLE`.
EtdStatus etd_render_release(EtdRender *render);

// Copies the message of the render's last failure, like `etd_scene_error`.
//
// Pointers:
// As `etd_scene_error`.
size_t etd_render_error(const EtdRender *render, char *text, size_t capacity);

// Renders until the limit in the settings is reached: samples, time or error. Returns `ETD_STATUS_CANCELLED` if it was
// cancelled; it may then be run again, without loss of samples, unless `adaptive` is "greedy". A render by "mlt" that finds no
// light fails, and keeps its samples. `watch` may be null.
//
// Pointers:
// `watch` is null, or a structure of its `struct_size`, with functions of these signatures.
EtdStatus etd_render_run(EtdRender *render,
                         const EtdWatch *watch);

// Takes `spp` more samples per pixel, like `etd_render_run`. Not for greedy adaptive renders that have samples.
//
// Pointers:
// As `etd_render_run`.
EtdStatus etd_render_add_samples(EtdRender *render,
                                 uint64_t spp,
                                 const EtdWatch *watch);

// Cancels the active run of a render as soon as possible, from any thread. Without an active run, it does nothing.
EtdStatus etd_render_cancel(EtdRender *render);

// Writes statistics and error estimates of a render.
//
// Pointers:
// `info` is null, or a structure of its `struct_size`.
EtdStatus etd_render_info(const EtdRender *render, EtdRenderInfo *info);

// Creates an empty scene, with a camera at the origin that looks along -z, and writes its handle. Its reference count
// is 1, to be released by `etd_scene_release`.
//
// Pointers:
// `scene` is null, or a handle may be written there.
EtdStatus etd_scene_create(EtdScene **scene);

// Increments the reference count of a scene.
EtdStatus etd_scene_retain(const EtdScene *scene);

// Decrements the reference count of a scene, which is freed at 0; renders created from it keep it alive. Null, and
// handles that were freed already, are `ETD_STATUS_INVALID_HANDLE`.
EtdStatus etd_scene_release(EtdScene *scene);

// Copies the message of the scene's last failure to `text`, truncated to `capacity` bytes including the terminating
// NUL, and returns its full length without the NUL. `text` may be null, to query the length.
//
// Pointers:
// `capacity` bytes may be written to `text`, unless it is null.
size_t etd_scene_error(const EtdScene *scene,
                       char *text,
                       size_t capacity);

// Loads a scene file or a bare model, by its extension, which replaces the description. It takes effect at the next commit.
//
// Pointers:
// `path` is null, or a NUL-terminated string.
EtdStatus etd_scene_load(EtdScene *scene,
                         const char *path);

// Sets the camera. On a committed scene this takes effect at once, and builds nothing, unless a different shutter
// changes the motion of objects.
//
// Pointers:
// `camera` is null, or a structure of its `struct_size`, whose pointers are null or valid.
EtdStatus etd_scene_set_camera(EtdScene *scene,
                               const EtdCamera *camera);

// Sets the image size and the reconstruction filter. On a committed scene this takes effect at once, and builds
// nothing.
//
// Pointers:
// `film` is null, or a structure of its `struct_size`.
EtdStatus etd_scene_set_film(EtdScene *scene,
                             const EtdFilm *film);

// Prepares the scene for rendering: checks it, and builds its acceleration structures. Parts that are added later take
// effect at the next commit, after which renders that were created before cannot continue. `tracing` may be null.
//
// Pointers:
// `tracing` is null, or a structure of its `struct_size`.
EtdStatus etd_scene_commit(EtdScene *scene,
                           const EtdTracing *tracing);

// Sets the transforms of `count` instances: `instances` are their numbers, `transforms` 12 numbers for each, row by row
// without a gap. On a committed scene this takes effect at once; only the top-level structure is built again, not those
// of groups; an instance that was added since the commit is `ETD_STATUS_INVALID_ARGUMENT`. Moving instances keep their
// keyframes, which are applied after the new transform.
//
// Pointers:
// The pointers are null, or `count` instances and transforms may be read.
EtdStatus etd_scene_set_transforms(EtdScene *scene,
                                   const uint32_t *instances,
                                   const double *transforms,
                                   size_t count);

// Writes statistics about preparing the scene.
//
// Pointers:
// `work` is null, or a structure of its `struct_size`.
EtdStatus etd_scene_work(const EtdScene *scene, EtdWork *work);

// Returns the description of a status: a static string, never to be freed.
const char *etd_status_text(int32_t status);

// Returns the version of the library at run time, such as "0.1.0": a static string, never to be freed. A program built
// with the header of one version runs with every later one of the same major version; while that is 0, of the same
// minor version.
const char *etd_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ETENDUE_H */
