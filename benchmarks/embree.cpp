// A crowd of spheres under one light by Embree 3: build the tree, then trace a primary ray and a shadow ray per
// pixel, in packets of 16, on one thread or several.
//
// embree SCENE.txt THREADS REPETITIONS [OUT.pfm]
// embree                                             (prints the version of Embree)
//
// SCENE.txt holds the width, height and field of view, the light's position and intensity, and of each sphere the
// centre, the radius and the color. Prints the median seconds of `build` and `trace` as JSON.

#include <embree3/rtcore.h>
#include <pmmintrin.h>
#include <xmmintrin.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

namespace {

constexpr int PACKET = 16;            // rays of a packet: a block of 4x4 pixels
constexpr int BLOCK = 4;
constexpr int TILE = 16;              // pixels along the side of a tile, which one thread takes at a time
constexpr float SHADOW_START = 1e-4f; // of the way to the light: keeps a surface from shadowing itself

struct Vec3 {
  float x, y, z;
};

Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct Scene {
  int width, height;
  float fov, intensity;
  Vec3 light;
  std::vector<float> spheres;  // x, y, z, radius of each, as Embree takes them
  std::vector<Vec3> colors;
};

Scene read_scene(const char* path) {
  Scene scene;
  FILE* file = std::fopen(path, "r");
  if (!file || std::fscanf(file, "%d %d %f %f %f %f %f", &scene.width, &scene.height, &scene.fov, &scene.light.x,
                           &scene.light.y, &scene.light.z, &scene.intensity) != 7) {
    std::fprintf(stderr, "cannot read %s\n", path);
    std::exit(1);
  }
  float x, y, z, radius;
  Vec3 color;
  while (std::fscanf(file, "%f %f %f %f %f %f %f", &x, &y, &z, &radius, &color.x, &color.y, &color.z) == 7) {
    scene.spheres.insert(scene.spheres.end(), {x, y, z, radius});
    scene.colors.push_back(color);
  }
  std::fclose(file);
  return scene;
}

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void flush_denormals() {
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
}

RTCScene build(RTCDevice device, const Scene& scene) {
  RTCScene built = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, scene.spheres.data(), 0,
                             4 * sizeof(float), scene.spheres.size() / 4);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(built, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(built);
  return built;
}

class Picture {
 public:
  Picture(const Scene& scene, RTCScene built)
      : pixels(3 * static_cast<size_t>(scene.width) * scene.height),
        scene_(scene),
        built_(built),
        pixel_(2 * std::tan(scene.fov * static_cast<float>(M_PI) / 360) / scene.height) {}

  void trace(int threads) {
    std::atomic<int> next(0);
    const int columns = (scene_.width + TILE - 1) / TILE, rows = (scene_.height + TILE - 1) / TILE;
    auto work = [&] {
      flush_denormals();
      for (int tile; (tile = next++) < columns * rows;) trace_tile(tile % columns * TILE, tile / columns * TILE);
    };
    std::vector<std::thread> others;
    for (int i = 1; i < threads; i++) others.emplace_back(work);
    work();
    for (std::thread& other : others) other.join();
  }

  std::vector<float> pixels;

 private:
  void trace_tile(int left, int top) {
    for (int y = top; y < std::min(top + TILE, scene_.height); y += BLOCK)
      for (int x = left; x < std::min(left + TILE, scene_.width); x += BLOCK) trace_block(x, y);
  }

  void trace_block(int left, int top) {
    alignas(64) int valid[PACKET];
    alignas(64) RTCRayHit16 primary;
    for (int i = 0; i < PACKET; i++) {
      const int x = left + i % BLOCK, y = top + i / BLOCK;
      valid[i] = x < scene_.width && y < scene_.height ? -1 : 0;
      set_ray(primary.ray, i, {0, 0, 0},
              {(x + 0.5f - 0.5f * scene_.width) * pixel_, (0.5f * scene_.height - y - 0.5f) * pixel_, -1}, 0,
              INFINITY);
      primary.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      primary.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, built_, &context, &primary);
    shade_block(left, top, primary, context);
  }

  // radiance = color / pi * I / (4 pi r^2) * cos(theta), in the light
  void shade_block(int left, int top, const RTCRayHit16& primary, RTCIntersectContext& context) {
    alignas(64) int lit[PACKET];
    alignas(64) RTCRay16 shadow;
    float radiance[PACKET];
    int any = 0;
    for (int i = 0; i < PACKET; i++) {
      const bool hit = primary.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
      const float t = hit ? primary.ray.tfar[i] : 0;
      const Vec3 point = {t * primary.ray.dir_x[i], t * primary.ray.dir_y[i], t * primary.ray.dir_z[i]};
      const Vec3 normal = {primary.hit.Ng_x[i], primary.hit.Ng_y[i], primary.hit.Ng_z[i]};
      const Vec3 way = scene_.light - point;
      const float cosine = hit ? dot(normal, way) / std::sqrt(dot(normal, normal) * dot(way, way)) : 0;
      lit[i] = cosine > 0 ? -1 : 0;
      any |= lit[i];
      radiance[i] = lit[i] ? scene_.intensity * cosine / (4 * static_cast<float>(M_PI * M_PI) * dot(way, way)) : 0;
      set_ray(shadow, i, point, way, SHADOW_START, 1);
    }
    if (any) rtcOccluded16(lit, built_, &context, &shadow);
    for (int i = 0; i < PACKET; i++) {
      const int x = left + i % BLOCK, y = top + i / BLOCK;
      if (x >= scene_.width || y >= scene_.height) continue;
      const bool in_light = lit[i] && shadow.tfar[i] >= 0;  // Embree marks blocked rays by -infinity
      const Vec3 color = in_light ? scene_.colors[primary.hit.primID[i]] : Vec3{0, 0, 0};
      float* pixel = &pixels[3 * (static_cast<size_t>(y) * scene_.width + x)];
      pixel[0] = color.x * radiance[i];
      pixel[1] = color.y * radiance[i];
      pixel[2] = color.z * radiance[i];
    }
  }

  template <class Rays>
  static void set_ray(Rays& rays, int i, Vec3 origin, Vec3 direction, float near, float far) {
    rays.org_x[i] = origin.x;
    rays.org_y[i] = origin.y;
    rays.org_z[i] = origin.z;
    rays.dir_x[i] = direction.x;
    rays.dir_y[i] = direction.y;
    rays.dir_z[i] = direction.z;
    rays.tnear[i] = near;
    rays.tfar[i] = far;
    rays.time[i] = 0;
    rays.mask[i] = -1;
    rays.flags[i] = 0;
    rays.id[i] = i;
  }

  const Scene& scene_;
  RTCScene built_;
  float pixel_;  // the side of a pixel at distance 1
};

// A portable float map stores its rows from the bottom up.
void write_pfm(const char* path, const Scene& scene, const std::vector<float>& pixels) {
  FILE* file = std::fopen(path, "wb");
  if (!file) std::exit(1);
  std::fprintf(file, "PF\n%d %d\n-1\n", scene.width, scene.height);
  for (int y = scene.height - 1; y >= 0; y--)
    std::fwrite(&pixels[3 * static_cast<size_t>(y) * scene.width], sizeof(float), 3 * scene.width, file);
  std::fclose(file);
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 4) {
    std::puts(RTC_VERSION_STRING);
    return 0;
  }
  const Scene scene = read_scene(arguments[1]);
  const int threads = std::atoi(arguments[2]), repetitions = std::atoi(arguments[3]);
  flush_denormals();
  char options[64];
  std::snprintf(options, sizeof options, "threads=%d,set_affinity=0", threads);
  RTCDevice device = rtcNewDevice(options);
  std::vector<double> builds, traces;
  RTCScene built = nullptr;
  for (int i = 0; i < repetitions; i++) {
    if (built) rtcReleaseScene(built);
    const double start = seconds();
    built = build(device, scene);
    builds.push_back(seconds() - start);
  }
  Picture picture(scene, built);
  for (int i = 0; i < repetitions; i++) {
    const double start = seconds();
    picture.trace(threads);
    traces.push_back(seconds() - start);
  }
  if (count > 4) write_pfm(arguments[4], scene, picture.pixels);
  std::printf("{\"build\": %.9f, \"trace\": %.9f}\n", median(builds), median(traces));
}
