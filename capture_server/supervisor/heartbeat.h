#pragma once

// A supervised child process reports to its parent in shared memory: the progress of its threads,
// its present activity and, after a crash, the crashed thread. The parent can read these reports at
// any time, even after the child's death.
// Thread: any thread of the child may call all functions. A Pulse belongs to one thread at a time.

#include <sys/types.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace copresence::server {

/// Text of limited size that one process writes and another reads. A text that is read during a
/// write may be a mixture of the old and the new text.
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

/// How long a thread may be silent.
enum class Pace : int {
  kUnused,   ///< No thread reports here.
  kResting,  ///< The thread waits for another thread, without a time limit.
  kWorking,  ///< At most SupervisorPolicy::silence.
  kOpening,  ///< At most SupervisorPolicy::opening.
};

enum class Stage : int {
  kPreparing,  ///< Reads files and opens the encoders.
  kOpening,    ///< Opens the camera or the recording.
  kRunning,    ///< Captures and streams frames.
  kEnding,     ///< Completes the work in progress.
};

/// The shared memory. The parent creates it before the child starts. Initially all bytes are zero.
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

  // The handler of a fatal signal writes these members.
  std::atomic<int> fatal_signal{0};
  std::atomic<pid_t> sender{0};  ///< The process that sent the signal; 0 for a fault.
  SharedText<16> crashed_thread;
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<Pace>::is_always_lock_free);

/// Reports that one thread makes progress.
class Pulse {
 public:
  explicit Pulse(ChildReport::Thread& thread) : thread_(&thread) {}

  /// The thread made progress. The next call follows within SupervisorPolicy::silence.
  void beat() { set(Pace::kWorking); }
  /// The thread waits for another thread, a viewer or a disk, so silence is not a fault.
  void rest() { set(Pace::kResting); }
  /// The thread is about to open or close a camera, which may take SupervisorPolicy::opening.
  void open() { set(Pace::kOpening); }

 private:
  void set(Pace pace) {
    thread_->pace.store(pace, std::memory_order_relaxed);
    thread_->beats.fetch_add(1, std::memory_order_release);
  }

  ChildReport::Thread* thread_;
};

/// Facts about the previous child process.
struct Predecessor {
  bool existed = false;
  std::string crashed_while;  ///< The child's activity if it crashed, else empty.
};

class Heartbeat {
 public:
  /// `report` outlives this.
  Heartbeat(ChildReport& report, Predecessor predecessor);

  /// The pulse of the main thread. The pulse begins in the state Pace::kOpening.
  Pulse& main() { return main_; }

  /// Creates a pulse for another thread. `name` has up to 15 characters and appears in messages.
  /// Requires at most ChildReport::kMostThreads threads in all.
  Pulse pulse(std::string_view name);

  void enter(Stage stage) { report_.stage = stage; }

  /// Reports the number of captured frames. The number shows where in a recording a crash happens.
  void captured(std::uint64_t frames) { report_.frames.store(frames, std::memory_order_relaxed); }

  const Predecessor& predecessor() const { return predecessor_; }

  /// Marks an activity that a message about the child's death names. The activity lasts as long as
  /// this object, also across stages.
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

  /// Begins an activity, of which only one may exist at a time. `what` describes the activity, such
  /// as "reading the scene file lab.toml". `remedy` is the advice after repeated crashes, such as
  /// "mend that file".
  [[nodiscard]] Activity doing(std::string_view what, std::string_view remedy);

  /// Installs handlers that write fatal signals (SIGSEGV and others) into the report.
  void note_crashes();

 private:
  ChildReport& report_;
  const Predecessor predecessor_;
  Pulse main_;
};

}  // namespace copresence::server
