#pragma once

// Reports of a supervised child to its parent, in shared memory: the progress of its threads, its
// present activity and, after a crash, the crashed thread. The parent can read it at any time, even
// after the child's death.
//
// Thread: all functions may be called from any thread of the child. A Pulse belongs to one thread
// at a time.

#include <sys/types.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace copresence::server {

/// Text of fixed size that one process writes and another reads. A text that is read during a write
/// may be a mixture.
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
  kResting,  ///< it waits for another thread, for any time
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

/// The shared memory. The parent creates it before the child starts; initially all zero.
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

  // About a fatal signal, from its handler.
  std::atomic<int> fatal_signal{0};
  std::atomic<pid_t> sender{0};  ///< the process that sent the signal; 0 for a fault
  SharedText<16> crashed_thread;
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<Pace>::is_always_lock_free);

/// Signs of life of one thread.
class Pulse {
 public:
  explicit Pulse(ChildReport::Thread& thread) : thread_(&thread) {}

  /// The thread made progress. The next beat follows within SupervisorPolicy::silence.
  void beat() { set(Pace::kWorking); }
  /// The thread waits for another thread, a viewer or a disk: silence is no fault.
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

/// The child before this one.
struct Predecessor {
  bool existed = false;
  std::string crashed_while;  ///< its activity if it crashed, else empty
};

class Heartbeat {
 public:
  /// `report` outlives this.
  Heartbeat(ChildReport& report, Predecessor predecessor);

  /// The pulse of the first thread. It begins in the state "opening".
  Pulse& main() { return main_; }

  /// A pulse for a further thread. `name`: up to 15 characters, for messages. Requires at most
  /// ChildReport::kMostThreads in all.
  Pulse pulse(std::string_view name);

  void enter(Stage stage) { report_.stage = stage; }

  /// The number of captured frames so far: the place in a recording at which a crash happens.
  void captured(std::uint64_t frames) { report_.frames.store(frames, std::memory_order_relaxed); }

  const Predecessor& predecessor() const { return predecessor_; }

  /// Marks an activity that a message about the child's death should name. It lasts as long as this
  /// object, also across stages.
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

  /// `what`: "reading the scene file lab.toml". `remedy`: advice if it crashes repeatedly, such as
  /// "mend that file". One at a time.
  [[nodiscard]] Activity doing(std::string_view what, std::string_view remedy);

  /// Installs handlers that note fatal signals (SIGSEGV, SIGABRT and others) in the report before
  /// they end the process.
  void note_crashes();

 private:
  ChildReport& report_;
  const Predecessor predecessor_;
  Pulse main_;
};

}  // namespace copresence::server
