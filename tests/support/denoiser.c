// A library with the functions of Open Image Denoise that the program uses, whose filter halves every colour. What is not
// right about it is said by macros: VERSION, NO_DEVICE (the type of a device that cannot be made), FAILS, LACKS_FILTERS.

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#ifndef VERSION
#define VERSION 20501
#endif
#ifndef NO_DEVICE
#define NO_DEVICE -1
#endif

struct device { int type; int error; const char *message; };
struct buffer { char *bytes; };
struct filter {
    struct device *device;
    struct buffer *colour, *output;
    size_t values;
    bool (*monitor)(void *, double);
    void *data;
};

static const char *made_no_device;

struct device *oidnNewDevice(int type)
{
    if (type == NO_DEVICE) {
        made_no_device = "no such device here";
        return NULL;
    }
    struct device *device = calloc(1, sizeof *device);
    device->type = 1;
    return device;
}
void oidnCommitDevice(struct device *device) { (void)device; }
void oidnReleaseDevice(struct device *device) { free(device); }
int oidnGetDeviceError(struct device *device, const char **message)
{
    if (!device) {
        *message = made_no_device;
        int error = made_no_device ? 5 : 0;
        made_no_device = NULL;
        return error;
    }
    int error = device->error;
    *message = device->message;
    device->error = 0;
    return error;
}
int oidnGetDeviceInt(struct device *device, const char *name)
{
    return strcmp(name, "version") == 0 ? VERSION : device->type;
}
void oidnSetDeviceBool(struct device *device, const char *name, bool value) { (void)device, (void)name, (void)value; }
int oidnGetNumPhysicalDevices(void) { return 1; }
int oidnGetPhysicalDeviceInt(int id, const char *name) { (void)id, (void)name; return 1; }
const char *oidnGetPhysicalDeviceString(int id, const char *name) { (void)id, (void)name; return "A test"; }

struct buffer *oidnNewBuffer(struct device *device, size_t size)
{
    (void)device;
    struct buffer *buffer = malloc(sizeof *buffer);
    buffer->bytes = calloc(1, size);
    return buffer;
}
void oidnWriteBuffer(struct buffer *buffer, size_t offset, size_t size, const void *from)
{
    memcpy(buffer->bytes + offset, from, size);
}
void oidnReadBuffer(struct buffer *buffer, size_t offset, size_t size, void *to)
{
    memcpy(to, buffer->bytes + offset, size);
}
void oidnReleaseBuffer(struct buffer *buffer) { free(buffer->bytes); free(buffer); }

#ifndef LACKS_FILTERS
struct filter *oidnNewFilter(struct device *device, const char *type)
{
    (void)type;
    struct filter *filter = calloc(1, sizeof *filter);
    filter->device = device;
    return filter;
}
#endif
void oidnSetFilterImage(struct filter *filter, const char *name, struct buffer *buffer, int format, size_t width,
                        size_t height, size_t offset, size_t pixel_stride, size_t row_stride)
{
    (void)offset, (void)pixel_stride, (void)row_stride;
    *(strcmp(name, "color") == 0 ? &filter->colour : &filter->output) = buffer;
    filter->values = width * height * (size_t)format;
}
void oidnSetFilterBool(struct filter *filter, const char *name, bool value) { (void)filter, (void)name, (void)value; }
void oidnSetFilterInt(struct filter *filter, const char *name, int value) { (void)filter, (void)name, (void)value; }
void oidnSetFilterFloat(struct filter *filter, const char *name, float value) { (void)filter, (void)name, (void)value; }
void oidnSetFilterProgressMonitorFunction(struct filter *filter, bool (*monitor)(void *, double), void *data)
{
    filter->monitor = monitor;
    filter->data = data;
}
void oidnCommitFilter(struct filter *filter) { (void)filter; }
void oidnExecuteFilter(struct filter *filter)
{
    if (filter->monitor && !filter->monitor(filter->data, 0.0)) {
        filter->device->error = 6;
        filter->device->message = "execution was cancelled";
        return;
    }
#ifdef FAILS
    filter->device->error = 4;
    filter->device->message = "not enough memory for the network";
    return;
#endif
    const float *from = (const float *)filter->colour->bytes;
    float *to = (float *)filter->output->bytes;
    for (size_t k = 0; k < filter->values; k++)
        to[k] = 0.5f * from[k];
}
void oidnReleaseFilter(struct filter *filter) { free(filter); }
