#include "tests/support/window_user.h"

// last: X defines words that others use as names
#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace copresence {
namespace {

Display* display_of(void* display) {
  return static_cast<Display*>(display);
}

void send(Display* display, ::Window window, XEvent& event, long mask) {
  XSendEvent(display, window, False, mask, &event);
  XSync(display, False);
}

// Without a window manager the program's window is a child of the root.
::Window find(Display* display, const std::string& title) {
  ::Window root = 0, parent = 0, result = 0, *children = nullptr;
  unsigned count = 0;
  XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count);
  for (unsigned i = 0; i < count; ++i) {
    char* name = nullptr;
    if (XFetchName(display, children[i], &name) && name && std::string(name).starts_with(title))
      result = children[i];
    if (name) XFree(name);
  }
  if (children) XFree(children);
  return result;
}

}  // namespace

WindowUser::WindowUser(const std::string& title)
    : display_(XOpenDisplay(nullptr)), window_(display_ ? find(display_of(display_), title) : 0) {}

WindowUser::~WindowUser() {
  if (display_) XCloseDisplay(display_of(display_));
}

void WindowUser::press(unsigned button, int x, int y, unsigned modifiers) {
  send_button(ButtonPress, button, x, y, modifiers);
}

void WindowUser::release(unsigned button, int x, int y, unsigned modifiers) {
  send_button(ButtonRelease, button, x, y, modifiers);
}

void WindowUser::send_button(int type, unsigned button, int x, int y, unsigned modifiers) {
  XEvent event{};
  event.xbutton.type = type;
  event.xbutton.window = window_;
  event.xbutton.button = button;
  event.xbutton.x = x;
  event.xbutton.y = y;
  event.xbutton.state = modifiers;
  send(display_of(display_), window_, event, ButtonPressMask);
}

void WindowUser::move(int x, int y) {
  XEvent event{};
  event.xmotion.type = MotionNotify;
  event.xmotion.window = window_;
  event.xmotion.x = x;
  event.xmotion.y = y;
  send(display_of(display_), window_, event, PointerMotionMask);
}

void WindowUser::press_key(const std::string& keysym) {
  XEvent event{};
  event.xkey.type = KeyPress;
  event.xkey.window = window_;
  event.xkey.keycode = XKeysymToKeycode(display_of(display_), XStringToKeysym(keysym.c_str()));
  // GLFW ignores a key that is pressed at the time of the press before.
  event.xkey.time = key_time_ += 100;
  send(display_of(display_), window_, event, KeyPressMask);
  event.xkey.type = KeyRelease;
  event.xkey.time = key_time_ += 50;
  send(display_of(display_), window_, event, KeyReleaseMask);
}

void WindowUser::click_close() {
  XEvent event{};
  event.xclient.type = ClientMessage;
  event.xclient.window = window_;
  event.xclient.message_type = XInternAtom(display_of(display_), "WM_PROTOCOLS", False);
  event.xclient.format = 32;
  event.xclient.data.l[0] = long(XInternAtom(display_of(display_), "WM_DELETE_WINDOW", False));
  send(display_of(display_), window_, event, NoEventMask);
}

void WindowUser::resize(unsigned width, unsigned height) {
  XResizeWindow(display_of(display_), window_, width, height);
  XSync(display_of(display_), False);
}

Image<Rgba8> WindowUser::see(int width, int height) const {
  XWindowAttributes attributes{};
  if (!XGetWindowAttributes(display_of(display_), window_, &attributes) || attributes.width < width ||
      attributes.height < height || attributes.map_state != IsViewable) {
    return {};
  }
  XImage* const shot =
      XGetImage(display_of(display_), window_, 0, 0, unsigned(width), unsigned(height), AllPlanes, ZPixmap);
  if (!shot) return {};
  Image<Rgba8> seen(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const unsigned long pixel = XGetPixel(shot, x, y);
      seen(x, y) = {std::uint8_t(pixel >> 16), std::uint8_t(pixel >> 8), std::uint8_t(pixel), 255};
    }
  }
  XDestroyImage(shot);
  return seen;
}

}  // namespace copresence
