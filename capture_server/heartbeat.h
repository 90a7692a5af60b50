#pragma once

// What a supervised child reports to its parent, in memory that both share: which of its threads make
// progress, what it is doing, and, when it crashes, on which thread. The parent reads it at any time, also
// after the child has died.
//
// Thread: any thread of the child may call anything. A Pulse belongs to one thread at a time.

#include <sys/types.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace copresence {

/// Text of fixed size that one process writes and another reads. A text that is read while it is written may
/// come out mixed.
template <std::size_t kSize>
class SharedText {
 public:
  void set(std::string_view text) {
    const std::size_t length = std::min(text.size(), kSize - 1);
    for (std::size_t i = 0; i < length; ++i) bytes_[i].store(text[i], std::memory_order_relaxed);
    bytes_[length].store('\0', std::memory_order_release);
  }
  std::string get() const {
    std::string text;
    for (std::size_t i = 0; i + 1 < kSize; ++i) {
      const char byte = bytes_[i].load(std::memory_order_relaxed);
      if (byte == '\0') break;
      text += byte;
    }
    return text;
  }

 private:
  std::array<std::atomic<char>, kSize> bytes_{};
};

/// How long a thread may go without a beat.
enum class Pace : int {
  kUnused,   ///< no thread reports here
  kResting,  ///< it waits for somebody else, for as long as that takes
  kWorking,  ///< SupervisorPolicy::silence
  kOpening,  ///< SupervisorPolicy::opening
};

/// The phases of a child's life.
enum class Stage : int {
  kPreparing,  ///< reads files, opens what frames pass through
  kOpening,    ///< opens the camera or the recording
  kRunning,    ///< frames come
  kEnding,     ///< finishes what it has begun
};

/// The shared memory. Placed by the parent before the child begins; all zero is its beginning.
struct ChildReport {
  static constexpr std::size_t kMostThreads = 8;

  struct Thread {
    std::atomic<Pace> pace{Pace::kUnused};
    std::atomic<std::uint64_t> beats{0};
    SharedText<16> name;
  };
  std::array<Thread, kMostThreads> threads;
  std::atomic<std::size_t> threads_used{0};

  std::atomic<Stage> stage{Stage::kPreparing};
  std::atomic<std::uint64_t> frames{0};
  SharedText<512> activity, remedy;

  // Of a fatal signal, noted by its handler.
  std::atomic<int> fatal_signal{0};
  std::atomic<pid_t> sender{0};  ///< the process that sent the signal; 0 where the kernel did, for a fault
  SharedText<16> crashed_thread;
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<Pace>::is_always_lock_free);

/// One thread's sign of life.
class Pulse {
 public:
  explicit Pulse(ChildReport::Thread& thread) : thread_(&thread) {}

  /// Made progress; the next beat comes within SupervisorPolicy::silence.
  void beat() { set(Pace::kWorking); }
  /// Waits for another thread, a viewer or a disk: silence is no fault.
  void rest() { set(Pace::kResting); }
  /// Is about to open or close a camera, which may take SupervisorPolicy::opening.
  void open() { set(Pace::kOpening); }

 private:
  void set(Pace pace) {
    thread_->pace.store(pace, std::memory_order_relaxed);
    thread_->beats.fetch_add(1, std::memory_order_release);
  }

  ChildReport::Thread* thread_;
};

/// What the parent knows of the child before this one.
struct Predecessor {
  bool existed = false;
  std::string crashed_while;  ///< its activity, where it crashed; else empty
};

class Heartbeat {
 public:
  /// `report` outlives this.
  Heartbeat(ChildReport& report, Predecessor predecessor);

  /// The first thread's own pulse. It begins as opening.
  Pulse& main() { return main_; }

  /// A further thread's. `name`: up to 15 characters, for sentences. Requires at most
  /// ChildReport::kMostThreads in all.
  Pulse pulse(std::string_view name);

  void enter(Stage stage) { report_.stage = stage; }

  /// Counts captured frames: the place in a recording at which a crash happened.
  void captured(std::uint64_t frames) { report_.frames.store(frames, std::memory_order_relaxed); }

  const Predecessor& predecessor() const { return predecessor_; }

  /// While one of these lives, the child does something that a sentence about its death should name. Also
  /// when it has entered another stage.
  class Activity {
   public:
    Activity(Activity&& other) noexcept : report_(std::exchange(other.report_, nullptr)) {}
    Activity& operator=(Activity&&) = delete;
    ~Activity() {
      if (report_) report_->activity.set("");
    }

   private:
    friend class Heartbeat;
    explicit Activity(ChildReport& report) : report_(&report) {}
    ChildReport* report_;
  };

  /// `what`: "reading the scene file lab.toml". `remedy`: what to do when that crashes again and again, "mend
  /// that file". One at a time.
  [[nodiscard]] Activity doing(std::string_view what, std::string_view remedy);

  /// From now on fatal signals (SIGSEGV, SIGABRT and others) are noted in the report before they end the
  /// process.
  void note_crashes();

 private:
  ChildReport& report_;
  const Predecessor predecessor_;
  Pulse main_;
};

}  // namespace copresence
