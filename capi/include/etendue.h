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

// `EtdSettings.flags`: have layers, to be read and written beside the picture. Samples are rounded up to a multiple of 4.
#define ETD_LAYERS 4

// `EtdSettings.flags`: `crop` is given.
#define ETD_HAS_CROP 8

// How a call ended. What is not `ETD_STATUS_OK` or `ETD_STATUS_CANCELLED` is a failure: the call has changed nothing, unless it says so, and
// the text of the handle that it was given says what was wrong.
typedef enum {
  // Done.
  ETD_STATUS_OK = 0,
  // Ended early because that was asked for; what is there so far is kept.
  ETD_STATUS_CANCELLED = 1,
  // An argument is null, out of its range, or makes no sense with the others.
  ETD_STATUS_INVALID_ARGUMENT = 2,
  // The handle is null, was released, or is none of this library's.
  ETD_STATUS_INVALID_HANDLE = 3,
  // The scene, a part of it, or a file that it names, is not valid.
  ETD_STATUS_INVALID_SCENE = 4,
  // A file could not be read or written.
  ETD_STATUS_INPUT_OUTPUT = 5,
  // The ray tracing library, or the rendering itself, failed.
  ETD_STATUS_RENDER_FAILED = 6,
  // There is not enough memory for what was asked.
  ETD_STATUS_OUT_OF_MEMORY = 7,
  // The handle is in use by another call that excludes this one: a render that is under way.
  ETD_STATUS_BUSY = 8,
  // The scene has not been committed yet.
  ETD_STATUS_NOT_COMMITTED = 9,
  // A mistake in the library itself, which is to be reported. The handle should be released.
  ETD_STATUS_INTERNAL = 10,
} EtdStatus;

// Libraries that trace rays.
typedef enum {
  // The preferred one of this build.
  ETD_BACKEND_DEFAULT = 0,
  // Intel Embree.
  ETD_BACKEND_EMBREE = 1,
  // obvhs with two children a node.
  ETD_BACKEND_OBVHS_BVH2 = 2,
  // obvhs with eight children a node.
  ETD_BACKEND_OBVHS_CWBVH = 3,
} EtdBackend;

// Reconstruction filters.
typedef enum {
  // A bell.
  ETD_FILTER_GAUSSIAN = 0,
  // The same weight everywhere.
  ETD_FILTER_BOX = 1,
  // A triangle.
  ETD_FILTER_TENT = 2,
  // Mitchell and Netravali's, with lobes below 0.
  ETD_FILTER_MITCHELL = 3,
  // Blackman and Harris's.
  ETD_FILTER_BLACKMAN_HARRIS = 4,
} EtdFilter;

// Kinds of numbers.
typedef enum {
  // 32-bit floats.
  ETD_FORMAT_FLOAT32 = 0,
  // 64-bit floats.
  ETD_FORMAT_FLOAT64 = 1,
} EtdFormat;

// Lights that are no shapes.
typedef enum {
  // Light from everywhere beyond the scene: `value` is radiance, or `panorama`; `transform`.
  ETD_LIGHT_KIND_ENVIRONMENT = 0,
  // A point: `value` is intensity, `position`.
  ETD_LIGHT_KIND_POINT = 1,
  // A point that shines into a cone: as a point, with `target`, `cone`, `penumbra`.
  ETD_LIGHT_KIND_SPOT = 2,
  // Parallel light: `value` is irradiance, `direction`.
  ETD_LIGHT_KIND_DISTANT = 3,
} EtdLightKind;

// How a material scatters.
typedef enum {
  // Lambert: `color`.
  ETD_MODEL_DIFFUSE = 0,
  // A perfect mirror: `color`.
  ETD_MODEL_MIRROR = 1,
  // Metal: `eta`, `k`, `roughness`.
  ETD_MODEL_CONDUCTOR = 2,
  // Glass and water: `ior`, `roughness`, and `color` as the tint of what is refracted.
  ETD_MODEL_DIELECTRIC = 3,
  // A highlight over a matte part: `color`, `specular`, `exponent`.
  ETD_MODEL_PHONG = 4,
  // A matte base under a clear coat: `color`, `ior`, `roughness`.
  ETD_MODEL_PLASTIC = 5,
  // The metallic-roughness model: `color`, `metallic`, `roughness`, `ior`, `transmission`.
  ETD_MODEL_PRINCIPLED = 6,
} EtdModel;

// How carefully rays are traced.
typedef enum {
  // Watertight along edges.
  ETD_PRECISION_ROBUST = 0,
  // About a third faster; may miss an edge.
  ETD_PRECISION_FAST = 1,
} EtdPrecision;

// A render of a scene, as far as it has come.
typedef struct EtdRender EtdRender;

// A scene.
typedef struct EtdScene EtdScene;

// A picture in the caller's memory, which is copied.
typedef struct {
  // sizeof(EtdImage)
  size_t struct_size;
  // Pixels in a row.
  uint32_t width;
  // Rows.
  uint32_t height;
  // Red, green and blue of each pixel, linear Rec. 709, row by row from the top.
  const float *rgb;
  // Bytes from one pixel to the next; 0 stands for three floats without a gap.
  size_t pixel_stride;
  // Multiplies every value; 0 stands for 1.
  float scale;
} EtdImage;

// A material. Fields that its model does not name are not looked at; sides, alpha and normals suit every model.
typedef struct {
  // sizeof(EtdMaterial)
  size_t struct_size;
  // For messages; may be null.
  const char *name;
  // An `EtdModel`.
  int32_t model;
  // The share of light that is sent on, from 0 to 1 in each channel.
  float color[3];
  // In place of `color`, by the texture coordinates of the shape; null for none.
  const EtdImage *texture;
  // The highlight's share; with `color` at most 1.
  float specular[3];
  // The highlight's power of the cosine, up to 1e6.
  float exponent;
  // From 0, smooth, to 1.
  float roughness;
  // Refractive index, inside over outside; 0 stands for 1.5.
  float ior;
  // From 0 to 1.
  float metallic;
  // From 0 to 1.
  float transmission;
  // Real part of a metal's refractive index, above 0.
  float eta[3];
  // Imaginary part of it.
  float k[3];
  // Other than 0: the back absorbs everything.
  uint32_t one_sided;
  // In place of `alpha`, by the texture coordinates of the shape: the luminance of each pixel counts, from 0 to 1; null for
  // none.
  const EtdImage *alpha_texture;
  // In place of `specular`, by the texture coordinates of the shape; null for none.
  const EtdImage *specular_texture;
  // A picture of normals, by the texture coordinates of the shape: red is along u, green along v, blue away from the surface,
  // each from -1 to 1 written as 0 to 1; null for none.
  const EtdImage *normal_map;
  // Multiplies red and green of the normals; 0 stands for 1.
  float normal_strength;
  // The share of the surface that is there, up to 1; where it is not, light passes straight on. 0 stands for 1.
  float alpha;
} EtdMaterial;

// The place of a shape or an instance at a time. Between two keys, translation and scale change evenly, and what is turned
// turns evenly, the shorter way; before the first and after the last one, things stand still.
typedef struct {
  // When, in the unit of the camera's shutter; above that of the key before.
  double time;
  // Where: what is applied after the object's own `transform`, 12 numbers, row by row.
  double transform[12];
} EtdKey;

// What a shape has beside its form.
typedef struct {
  // sizeof(EtdSurface)
  size_t struct_size;
  // For messages; may be null.
  const char *name;
  // The material, as `etd_scene_add_material` numbers them.
  uint32_t material;
  // The group that the shape belongs to, as `etd_scene_add_group` numbers them; 0 stands in the world itself.
  uint32_t group;
  // Emitted radiance; all zeros do not emit.
  float emission[3];
  // Other than 0: both sides emit, else the side that the geometric normal points to.
  uint32_t two_sided_emission;
  // Shape to world, or to its group: the three upper rows of a matrix, row by row, 12 numbers; null leaves the shape as it is.
  const double *transform;
  // In place of `emission`, by the texture coordinates of the shape; null for none.
  const EtdImage *emission_texture;
  // Where the shape is at which time; null for a shape that stands still. It moves while the camera's shutter is open.
  const EtdKey *motion;
  // Keys, in order of time.
  size_t motion_count;
  // Bytes from one key to the next; 0 stands for keys without a gap.
  size_t motion_stride;
} EtdSurface;

// Triangles with shared vertices, in the caller's memory, which is copied. Strides are bytes from one item to the next; 0 stands
// for items without a gap. Addresses need no alignment.
typedef struct {
  // sizeof(EtdMesh)
  size_t struct_size;
  // x, y and z of each vertex.
  const void *positions;
  // Vertices, below 2^32.
  size_t vertex_count;
  // Bytes from one position to the next.
  size_t position_stride;
  // An `EtdFormat`, of positions alone: other numbers are 32-bit floats.
  int32_t position_format;
  // A shading normal for each vertex, of any length; null for none.
  const float *normals;
  // Bytes from one normal to the next.
  size_t normal_stride;
  // u and v of each vertex, v up; null for none.
  const float *uvs;
  // Bytes from one texture coordinate to the next.
  size_t uv_stride;
  // Three vertices of each triangle; the geometric normal is (b - a) x (c - a).
  const uint32_t *indices;
  // Triangles, below 2^32.
  size_t triangle_count;
  // Bytes from one triangle to the next.
  size_t index_stride;
} EtdMesh;

// A group of shapes, placed once more.
typedef struct {
  // sizeof(EtdInstance)
  size_t struct_size;
  // For messages; may be null.
  const char *name;
  // The group that is placed, as `etd_scene_add_group` numbers them.
  uint32_t of;
  // The group that the instance belongs to; 0 stands in the world itself.
  uint32_t group;
  // Group to world, or to the group that the instance belongs to: 12 numbers, row by row; null leaves it where it is.
  const double *transform;
  // Where the instance is at which time; null for one that stands still. It moves while the camera's shutter is open.
  const EtdKey *motion;
  // Keys, in order of time.
  size_t motion_count;
  // Bytes from one key to the next; 0 stands for keys without a gap.
  size_t motion_stride;
} EtdInstance;

// A light that is no shape. Fields that its kind does not name are not looked at.
typedef struct {
  // sizeof(EtdLight)
  size_t struct_size;
  // An `EtdLightKind`.
  int32_t kind;
  // Radiance, intensity or irradiance, at least 0.
  float value[3];
  // In place of `value`, all around: its middle is seen along -z, its right half towards +x, its top along +y; null for
  // none.
  const EtdImage *panorama;
  // Where the light is.
  double position[3];
  // Where a spot points.
  double target[3];
  // Where distant light goes.
  double direction[3];
  // Angle from a spot's axis to its edge in degrees, up to 180.
  double cone;
  // The outer part of that angle over which a spot falls off, in degrees.
  double penumbra;
  // From the axes of the panorama to those of the world: 12 numbers, row by row, a rotation only; null leaves it as it is.
  const double *transform;
} EtdLight;

// A ray through the world.
typedef struct {
  // Where it starts.
  double origin[3];
  // Where it goes, of any length but 0.
  double direction[3];
  // What is at this distance or nearer does not count.
  double min_distance;
  // What is farther does not count; 0 stands for any distance.
  double max_distance;
  // When, from 0 to 1 while the shutter is open.
  double time;
} EtdRay;

// What a ray meets first.
typedef struct {
  // 1 if it meets something, else 0, and all other fields are 0.
  uint32_t met;
  // The shape's number.
  uint32_t shape;
  // The primitive's index in the shape, among those that have an area.
  uint32_t primitive;
  // 0.
  uint32_t reserved;
  // How far it is.
  double distance;
  // Where it is.
  double position[3];
  // Geometric normal of unit length, on the shape's front.
  double normal[3];
  // The normal that is shaded with: towards the ray, or outwards on what light passes through.
  double shading_normal[3];
  // Texture coordinates; 0 where nothing on the shape asks for them.
  double uv[2];
} EtdHit;

// What is asked of a render. Zeros and null stand for what the scene says, and then for the defaults.
typedef struct {
  // sizeof(EtdSettings)
  size_t struct_size;
  // `ETD_HAS_SEED` and others, added.
  uint32_t flags;
  // Scattering events at most, with `ETD_HAS_MAX_BOUNCES`. Biases.
  uint32_t max_bounces;
  // Samples per pixel.
  uint64_t spp;
  // Seconds at most.
  double seconds;
  // The error to reach, the root of relMSE, such as 0.01.
  double error;
  // The probability with which that error is kept; 0 stands for 0.95.
  double confidence;
  // Picks one of 2^64 sets of random numbers, with `ETD_HAS_SEED`.
  uint64_t seed;
  // The estimator, such as "path" or "ambient-occlusion".
  const char *integrator;
  // Where random numbers come from: "sobol", "stratified" or "independent".
  const char *sampler;
  // How samples are given out to pixels: "off", "two-phase" or "greedy".
  const char *adaptive;
  // When paths end by chance: "none", "albedo" or "throughput".
  const char *roulette;
  // How far, in world units, something may be and still count for ambient occlusion.
  double occlusion_distance;
  // The share of indirect light up to which "irradiance-cache" may be wrong, such as 0.05; below 1.
  double cache_error;
  // With `ETD_HAS_CROP`, x0, y0, x1, y1: only the pixels from (x0, y0) up to but not including (x1, y1) are rendered.
  uint32_t crop[4];
} EtdSettings;

// How far a render has come.
typedef struct {
  // Size of this structure in bytes.
  size_t struct_size;
  // Samples so far, over all pixels.
  uint64_t samples;
  // Complete samples per pixel; in the mean, where pixels differ.
  uint64_t spp;
  // Seconds since the call began.
  double seconds;
  // The share of what was asked for that is done, from 0 to 1.
  double fraction;
  // The estimated error so far, the root of relMSE; not a number before it can be told.
  double rel_rmse;
} EtdProgress;

// A picture while it becomes: borrowed for the time of the call that gets it.
typedef struct {
  // Size of this structure in bytes.
  size_t struct_size;
  // Pixels in a row.
  uint32_t width;
  // Rows.
  uint32_t height;
  // Red, green and blue of each pixel, linear Rec. 709, row by row from the top without a gap.
  const float *rgb;
} EtdPicture;

// Who watches a render. Any of its functions may be null. None may throw, longjmp, or wait for the render that calls it; all may
// call this library, where `ETD_STATUS_BUSY` answers what the render excludes.
typedef struct {
  // sizeof(EtdWatch)
  size_t struct_size;
  // Handed to each function.
  void *user;
  // Called often, from any of the render's threads and from several at once. Other than 0 ends the render as soon as it can; the
  // samples so far are kept. The progress is borrowed for the time of the call.
  int32_t (*progress)(void *user, const EtdProgress *progress);
  // Called after each pass over the picture, from one of the render's threads while the others wait.
  void (*picture)(void *user, const EtdPicture *picture);
} EtdWatch;

// What is known of a render.
typedef struct {
  // sizeof(EtdRenderInfo), to be set before the call.
  size_t struct_size;
  // Pixels in a row of what is rendered.
  uint32_t width;
  // Rows of it.
  uint32_t height;
  // Complete samples per pixel; in the mean, where pixels differ.
  uint64_t spp;
  // Samples in all pixels together.
  uint64_t samples;
  // Rays traced.
  uint64_t rays;
  // Samples that were not finite, and were left out.
  uint64_t rejected;
  // Seconds that rendering took so far.
  double seconds;
  // 1 if the last call was cancelled.
  uint32_t cancelled;
  // 1 if the last call ended because the error that was asked for was reached.
  uint32_t reached;
  // Estimated error, the root of relMSE; not a number before it can be told, from four samples a pixel on.
  double rel_rmse;
  // With `confidence`, the error is below this; not a number before that can be told, infinite where rare bright paths hold
  // so much of the error that the samples do not tell a bound.
  double rel_rmse_upper;
  // The confidence of that.
  double confidence;
  // The share of pixels whose error bars are not to be trusted.
  double uncalibrated_fraction;
  // The error is at least this where there is no bound; else 0.
  double rel_rmse_at_least;
} EtdRenderInfo;

// The place of a camera at a time.
typedef struct {
  // When; above that of the key before.
  double time;
  // Where it is.
  double eye[3];
  // What it looks at.
  double target[3];
  // What is up; all zeros stand for y.
  double up[3];
} EtdCameraKey;

// A perspective camera.
typedef struct {
  // sizeof(EtdCamera)
  size_t struct_size;
  // Where it is.
  double eye[3];
  // What it looks at.
  double target[3];
  // What is up; all zeros stand for y.
  double up[3];
  // Vertical field of view in degrees, below 180; 0 stands for 40.
  double fov;
  // Radius of the lens; 0 is a pinhole.
  double lens_radius;
  // Distance of the plane in focus; 0 stands for that of the target, of the first key if the camera moves.
  double focus_distance;
  // Two times: when the shutter opens and when it closes, in the unit of all keys. If they are equal, everything stands still
  // as it is then. Null leaves the shutter as it is; that of a new scene is { 0, 0 }.
  const double *shutter;
  // Where the camera is at which time, in place of `eye`, `target` and `up`; null for a camera that stands still.
  const EtdCameraKey *motion;
  // Keys, in order of time.
  size_t motion_count;
  // Bytes from one key to the next; 0 stands for keys without a gap.
  size_t motion_stride;
} EtdCamera;

// The picture.
typedef struct {
  // sizeof(EtdFilm)
  size_t struct_size;
  // Pixels in a row, from 1 to 65536.
  uint32_t width;
  // Rows, from 1 to 65536.
  uint32_t height;
  // The reconstruction filter, an `EtdFilter`.
  int32_t filter;
  // Its radius in pixels, up to 32; 0 stands for the filter's own.
  double filter_radius;
} EtdFilm;

// How a scene is traced. Zeros stand for the defaults.
typedef struct {
  // sizeof(EtdTracing)
  size_t struct_size;
  // An `EtdBackend`.
  int32_t backend;
  // An `EtdPrecision`.
  int32_t precision;
  // Threads that build and render; 0 stands for all that the process may use.
  uint32_t threads;
} EtdTracing;

// What was done so far to make a scene ready.
typedef struct {
  // sizeof(EtdWork), to be set before the call.
  size_t struct_size;
  // How often everything was made ready since the last commit, all acceleration structures built: 1 after it, and once more
  // for a change that can do with no less.
  uint64_t builds;
  // How often groups were placed anew, with nothing built but the structure above them.
  uint64_t placements;
  // How often the camera or the film was replaced, with nothing built.
  uint64_t cameras;
  // Seconds that the last of these took.
  double seconds;
} EtdWork;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Adds a material, and writes its number, counted from 0, unless `number` is null. Textures are copied.
//
// Pointers:
// `material` is null, or a structure as long as it says, whose pointers are null or lead to what it says.
EtdStatus etd_scene_add_material(EtdScene *scene,
                                 const EtdMaterial *material,
                                 uint32_t *number);

// Adds triangles, and writes the number of the shape, counted from 0, unless `number` is null. All buffers are copied.
//
// Pointers:
// `surface` and `mesh` are null, or structures as long as they say, whose pointers are null or lead to what they say.
EtdStatus etd_scene_add_mesh(EtdScene *scene,
                             const EtdSurface *surface,
                             const EtdMesh *mesh,
                             uint32_t *number);

// Adds a sphere about `center`, three numbers, and writes the number of the shape unless `number` is null.
//
// Pointers:
// As `etd_scene_add_mesh`; `center` is null, or three numbers.
EtdStatus etd_scene_add_sphere(EtdScene *scene,
                               const EtdSurface *surface,
                               const double *center,
                               double radius,
                               uint32_t *number);

// Adds a flat disk about `center`, with a normal of any length, and writes the number of the shape unless `number` is null.
//
// Pointers:
// As `etd_scene_add_sphere`, of `normal` too.
EtdStatus etd_scene_add_disk(EtdScene *scene,
                             const EtdSurface *surface,
                             const double *center,
                             const double *normal,
                             double radius,
                             uint32_t *number);

// Adds a parallelogram with the normal edge_u x edge_v, and writes the number of the shape unless `number` is null.
//
// Pointers:
// As `etd_scene_add_sphere`, of corner and edges.
EtdStatus etd_scene_add_rectangle(EtdScene *scene,
                                  const EtdSurface *surface,
                                  const double *corner,
                                  const double *edge_u,
                                  const double *edge_v,
                                  uint32_t *number);

// Adds an axis-aligned box whose normals point outwards, and writes the number of the shape unless `number` is null.
//
// Pointers:
// As `etd_scene_add_sphere`, of both corners.
EtdStatus etd_scene_add_box(EtdScene *scene,
                            const EtdSurface *surface,
                            const double *min,
                            const double *max,
                            uint32_t *number);

// Adds a group without members yet, and writes its number, counted from 1: 0 stands for the world itself. `name` is for
// messages and may be null.
//
// Pointers:
// `name` is null, or a text that ends with a NUL; `number` is null, or may be written.
EtdStatus etd_scene_add_group(EtdScene *scene,
                              const char *name,
                              uint32_t *number);

// Adds an instance of a group, and writes its number, counted from 0, unless `number` is null.
//
// Pointers:
// `instance` is null, or a structure as long as it says, whose pointers are null or lead to what it says.
EtdStatus etd_scene_add_instance(EtdScene *scene,
                                 const EtdInstance *instance,
                                 uint32_t *number);

// Adds a light that is no shape. Its panorama is copied; there may be one at most.
//
// Pointers:
// `light` is null, or a structure as long as it says, whose pointers are null or lead to what it says.
EtdStatus etd_scene_add_light(EtdScene *scene,
                              const EtdLight *light);

// Tells what each of `count` rays meets first. Strides are bytes from one item to the next; 0 stands for items without a gap. May
// be called from any number of threads at once. A surface that is only partly there counts where more than half of it is.
//
// Pointers:
// The pointers are null, or as many rays are there, and as many hits may be written.
EtdStatus etd_scene_intersect(const EtdScene *scene,
                              const EtdRay *rays,
                              size_t count,
                              size_t ray_stride,
                              EtdHit *hits,
                              size_t hit_stride);

// Tells of each of `count` rays whether anything lies on it: 1 or 0 for each, without a gap. May be called from any number of
// threads at once.
//
// Pointers:
// The pointers are null, or as many rays are there, and as many bytes may be written.
EtdStatus etd_scene_occluded(const EtdScene *scene,
                             const EtdRay *rays,
                             size_t count,
                             size_t ray_stride,
                             uint8_t *occluded);

// Estimates the radiance that comes along each of `count` rays to its origin by `spp` samples, on the scene's threads: red, green
// and blue for each ray, without a gap. Where `standard_errors` is not null, their standard errors too, and `spp` is rounded
// up to a multiple of 4. Of the settings, which may be null, limits, crop and flags for layers do not count.
//
// Pointers:
// The pointers are null, or what they say is there; three floats for each ray may be written to the last two.
EtdStatus etd_scene_radiance(const EtdScene *scene,
                             const EtdSettings *settings,
                             const EtdRay *rays,
                             size_t count,
                             size_t ray_stride,
                             uint64_t spp,
                             float *radiance,
                             float *standard_errors);

// Copies the picture to `pixels`, where `size` bytes may be written: red, green and blue of each pixel as three floats, linear
// Rec. 709, row by row from the top. Strides are bytes from one pixel or row to the next; 0 stands for no gap.
//
// Pointers:
// `pixels` is null, or so many bytes may be written.
EtdStatus etd_render_read_pixels(const EtdRender *render,
                                 float *pixels,
                                 size_t size,
                                 size_t pixel_stride,
                                 size_t row_stride);

// Copies the standard error of each pixel, as `etd_render_read_pixels`, from four samples a pixel on. An interval of 95 % is two
// of them to either side; for others, the layer "freedom.Y" has the degrees of freedom of Student's t, scaled to variance 1.
//
// Pointers:
// As `etd_render_read_pixels`.
EtdStatus etd_render_read_standard_errors(const EtdRender *render,
                                          float *pixels,
                                          size_t size,
                                          size_t pixel_stride,
                                          size_t row_stride);

// Copies a layer, one float a pixel, as `etd_render_read_pixels`; its name is one of those of docs/accuracy.md, such as "albedo.R",
// "depth.Z" or "spp.Y". For renders with `ETD_LAYERS`. What is seen first is traced when a layer is asked for the first time.
//
// Pointers:
// As `etd_render_read_pixels`; `name` is null, or a text that ends with a NUL.
EtdStatus etd_render_read_layer(const EtdRender *render,
                                const char *name,
                                float *pixels,
                                size_t size,
                                size_t pixel_stride,
                                size_t row_stride);

// Writes the picture to a file, whole or not at all: `.exr`, with all layers if the render has them, `.png`, `.hdr` or `.pfm`.
//
// Pointers:
// `path` is null, or a text that ends with a NUL.
EtdStatus etd_render_write(const EtdRender *render,
                           const char *path);

// Begins a render of a committed scene, without a sample yet, and writes its handle, to be released by `etd_render_release`. It
// keeps the scene as long as it lives. `settings` may be null. A failure leaves its text with the scene.
//
// Pointers:
// `settings` is null, or a structure as long as it says, whose pointers are null or texts; `render` is null, or a handle may be
// written there.
EtdStatus etd_render_create(const EtdScene *scene,
                            const EtdSettings *settings,
                            EtdRender **render);

// Holds a render once more.
EtdStatus etd_render_retain(const EtdRender *render);

// Holds a render once less. Nobody's render is freed, once it does not run. Null, and what was released already, are
// `ETD_STATUS_INVALID_HANDLE`.
EtdStatus etd_render_release(EtdRender *render);

// The text of the render's last failure, as `etd_scene_error`.
//
// Pointers:
// As `etd_scene_error`.
size_t etd_render_error(const EtdRender *render, char *text, size_t capacity);

// Renders until what the settings say is met: samples, a time or an error. Returns when it is, or `ETD_STATUS_CANCELLED`. A render that
// was cancelled may be run again, and loses nothing. `watch` may be null.
//
// Pointers:
// `watch` is null, or a structure as long as it says, with functions of these signatures.
EtdStatus etd_render_run(EtdRender *render,
                         const EtdWatch *watch);

// Takes `spp` more samples in each pixel, as `etd_render_run`. Not for adaptive renders that have begun.
//
// Pointers:
// As `etd_render_run`.
EtdStatus etd_render_add_samples(EtdRender *render,
                                 uint64_t spp,
                                 const EtdWatch *watch);

// Ends the run of a render that is under way, from any thread, as soon as it can. Without one nothing happens.
EtdStatus etd_render_cancel(EtdRender *render);

// Tells what is known of a render.
//
// Pointers:
// `info` is null, or a structure as long as it says.
EtdStatus etd_render_info(const EtdRender *render, EtdRenderInfo *info);

// Makes an empty scene, seen from the origin along -z, and writes its handle. It is held once, to be released by
// `etd_scene_release`.
//
// Pointers:
// `scene` is null, or a handle may be written there.
EtdStatus etd_scene_create(EtdScene **scene);

// Holds a scene once more.
EtdStatus etd_scene_retain(const EtdScene *scene);

// Holds a scene once less. Nobody's scene is freed; renders that have begun keep it as long as they live. Null, and what was
// released already, are `ETD_STATUS_INVALID_HANDLE`.
EtdStatus etd_scene_release(EtdScene *scene);

// Copies the text of the scene's last failure to `text`, cut to `capacity` bytes with the NUL that ends it, and returns its whole
// length without the NUL. `text` may be null, to ask for the length.
//
// Pointers:
// `capacity` bytes may be written to `text`, unless it is null.
size_t etd_scene_error(const EtdScene *scene,
                       char *text,
                       size_t capacity);

// Reads a scene from a `.toml` file or a bare `.obj` model, in place of what is there. It still has to be committed.
//
// Pointers:
// `path` is null, or a text that ends with a NUL.
EtdStatus etd_scene_load(EtdScene *scene,
                         const char *path);

// Looks from somewhere else. On a committed scene this is effective at once, and builds nothing, unless another shutter makes
// something move, or move otherwise.
//
// Pointers:
// `camera` is null, or a structure as long as it says, whose pointers are null or lead to what it says.
EtdStatus etd_scene_set_camera(EtdScene *scene,
                               const EtdCamera *camera);

// Makes pictures of another size or by another filter. On a committed scene this is effective at once, and builds nothing.
//
// Pointers:
// `film` is null, or a structure as long as it says.
EtdStatus etd_scene_set_film(EtdScene *scene,
                             const EtdFilm *film);

// Makes the scene ready: checks it, and builds its acceleration structures. What is added later counts from the next commit on;
// renders that have begun cannot go on then. `tracing` may be null.
//
// Pointers:
// `tracing` is null, or a structure as long as it says.
EtdStatus etd_scene_commit(EtdScene *scene,
                           const EtdTracing *tracing);

// Places `count` instances anew: `instances` are their numbers, `transforms` 12 numbers for each, row by row without a gap. On a
// committed scene this is effective at once; groups are not built again, only the structure above them. What moves keeps its
// keys, which are applied after the new transform.
//
// Pointers:
// The pointers are null, or as many numbers are there.
EtdStatus etd_scene_set_transforms(EtdScene *scene,
                                   const uint32_t *instances,
                                   const double *transforms,
                                   size_t count);

// Tells what was done so far to make the scene ready.
//
// Pointers:
// `work` is null, or a structure as long as it says.
EtdStatus etd_scene_work(const EtdScene *scene, EtdWork *work);

// A status in words: a text that is always there and never to be freed.
const char *etd_status_text(int32_t status);

// The version of the library that runs, such as "0.1.0": a text that is always there and never to be freed. A program that
// was built with the header of one version runs with every later one of the same major version; while that is 0, of the same
// minor version.
const char *etd_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ETENDUE_H */
