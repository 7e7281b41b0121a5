/* A libdc1394 with two cameras that deliver numbered frames (five, if not told otherwise), to test the binding. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct { uint16_t unit; uint64_t guid; } camera_id;
typedef struct { uint32_t num; camera_id *ids; } camera_list;
typedef struct { /* dc1394camera_t */
    uint64_t guid;
    int unit;
    uint32_t unit_spec_ID, unit_sw_version, unit_sub_sw_version, command_registers_base;
    uint32_t unit_directory, unit_dependent_directory;
    uint64_t advanced_features_csr, PIO_control_csr, SIO_control_csr, strobe_control_csr;
    uint64_t format7_csr[8];
    int iidc_version;
    char *vendor, *model;
    uint32_t vendor_id, model_id;
} camera_info;
typedef struct {
    unsigned char *image;
    uint32_t size[2], position[2];
    int color_coding, color_filter;
    uint32_t yuv_byte_order, data_depth, stride;
    int video_mode;
    uint64_t total_bytes;
    uint32_t image_bytes, padding_bytes, packet_size, packets_per_frame;
    uint64_t timestamp;
    uint32_t frames_behind;
    void *camera;
    uint32_t id;
    uint64_t allocated_image_bytes;
    int little_endian, data_in_padding;
} video_frame;

enum { STRIDE = 656 };
static unsigned char pixels[STRIDE * 480];
static video_frame frame;
static camera_info the_camera = {
    .guid = 0x00b09d0100112233ULL, .vendor = "Point Grey Research", .model = "Dragonfly Express"
};
static int polls, delivered, outstanding;
int most_frames = 5; /* a test may change it */
int clock_set_s = 0; /* by how much the computer's clock was set: a test may change it */
/* What the test asks about afterwards. */
int seen_mode, seen_rate, seen_speed, seen_transmission, freed, enqueued, old_bus;

void *dc1394_new(void) { polls = delivered = outstanding = enqueued = freed = 0; return &polls; }
void dc1394_free(void *bus) { freed += bus == &polls; }
int dc1394_camera_enumerate(void *bus, camera_list **list) {
    if (bus != &polls) return -1;
    *list = malloc(sizeof **list);
    (*list)->num = 2;
    (*list)->ids = calloc(2, sizeof(camera_id));
    (*list)->ids[0].guid = 0x00b09d0100aabbccULL;
    (*list)->ids[1].guid = 0x00b09d0100112233ULL;
    return 0;
}
void dc1394_camera_free_list(camera_list *list) { free(list->ids); free(list); }
void *dc1394_camera_new(void *bus, uint64_t guid) {
    return bus == &polls && guid == 0x00b09d0100112233ULL ? &the_camera : NULL;
}
void dc1394_camera_free(void *camera) { freed += camera == (void *)&the_camera; }
int dc1394_video_set_operation_mode(void *camera, int mode) {
    return camera == (void *)&the_camera && mode == 481 && !old_bus ? 0 : -1;
}
int dc1394_video_set_iso_speed(void *camera, int speed) { seen_speed = speed; return 0; }
int dc1394_video_set_mode(void *camera, int mode) { seen_mode = mode; return 0; }
int dc1394_video_set_framerate(void *camera, int rate) { seen_rate = rate; return 0; }
int dc1394_video_set_transmission(void *camera, int on) { seen_transmission = on; return 0; }
int dc1394_capture_setup(void *camera, uint32_t buffers, uint32_t flags) {
    return buffers >= 4 && flags == 4 ? 0 : -7;
}
int dc1394_capture_stop(void *camera) { return 0; }
int dc1394_capture_dequeue(void *camera, int policy, video_frame **out) {
    *out = NULL;
    if (policy != 673 || outstanding) return -21;
    if (delivered >= most_frames || ++polls % 3) return 0; /* nothing has come yet */
    memset(pixels, 255, sizeof pixels);
    for (int row = 0; row < 480; row++) memset(pixels + row * STRIDE, 10 + delivered, 640);
    memset(&frame, 0, sizeof frame);
    frame.image = pixels;
    frame.size[0] = 640;
    frame.size[1] = 480;
    frame.stride = STRIDE;
    frame.timestamp = 1700000000000000ULL + 33333ULL * delivered + 1000000LL * clock_set_s;
    delivered++;
    outstanding = 1;
    *out = &frame;
    return 0;
}
int dc1394_capture_enqueue(void *camera, video_frame *back) {
    outstanding = 0;
    enqueued += back == &frame;
    return 0;
}
const char *dc1394_error_get_string(int code) { return code == -7 ? "Capture not set" : "Failure"; }
