// Counts forbidden operations of the beat in the real program: preloaded into odomd (LD_PRELOAD),
// it interposes the functions of libc that allocate, lock and throw, and counts the calls of the
// thread `odomd-beat` from its first wake-up on, for a given number of ticks. The calls of all
// other threads are counted separately, which shows that the interposition works. The page faults
// of the thread are those of getrusage(2) over the same span, the sleeps included.
//
//   TICK_COUNTERS_OUT=FILE     file for the counts, written after N ticks
//   TICK_COUNTERS_TICKS=N      number of ticks (default 10000)
//   TICK_COUNTERS_INJECT=WHAT  performs an allocation, lock, exception or fault in the first tick
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <mutex>
#include <stdexcept>
#include <string_view>

namespace {

struct Counts {
  std::atomic<std::uint64_t> allocations{0};  // includes releases of memory
  std::atomic<std::uint64_t> locks{0};
  std::atomic<std::uint64_t> exceptions{0};
};
Counts of_beat;
Counts of_others;

enum class Thread : std::uint8_t { unknown, other, beat };

// Accessed without a call that might allocate: the loader reserves the space at start.
__attribute__((tls_model("initial-exec"))) thread_local Thread thread = Thread::unknown;
__attribute__((tls_model("initial-exec"))) thread_local bool counting = false;

Counts& counts() {
  return counting ? of_beat : of_others;
}
void count(std::atomic<std::uint64_t>& counter) {
  counter.fetch_add(1, std::memory_order_relaxed);
}

// libc's own function, looked up at the first call.
template <typename Function>
class Next {
 public:
  explicit constexpr Next(const char* name) : name_(name) {}
  Function* get() {
    Function* function = function_.load(std::memory_order_relaxed);
    if (function == nullptr) {
      void* symbol = dlsym(RTLD_NEXT, name_);
      if (symbol == nullptr) std::abort();
      static_assert(sizeof function == sizeof symbol);
      std::memcpy(&function, &symbol, sizeof function);
      function_.store(function, std::memory_order_relaxed);
    }
    return function;
  }

 private:
  const char* name_;
  std::atomic<Function*> function_{nullptr};
};

template <std::size_t size>
struct Name {
  consteval Name(const char (&name)[size]) { std::copy_n(name, size, text); }
  char text[size]{};
};

template <Name name, typename... Arguments>
int counted_lock(Arguments... arguments) {
  constinit static Next<int(Arguments...)> next(name.text);
  count(counts().locks);
  return next.get()(arguments...);
}

// The counted span --------------------------------------------------------------------------------

struct Faults {
  std::int64_t minor = 0;
  std::int64_t major = 0;
};

Faults faults_of_this_thread() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {usage.ru_minflt, usage.ru_majflt};
}

struct Span {
  std::uint64_t ticks = 0;
  std::uint64_t wanted = 10000;
  Faults before;
  bool done = false;
};
Span span;  // of the beat only

const char* text_of(const char* variable, const char* otherwise) {
  const char* text = std::getenv(variable);
  return text != nullptr ? text : otherwise;
}

constexpr std::size_t page_size = 65536;  // the machine's, or more
alignas(page_size) char page[page_size];

void inject(std::string_view what) {
  static std::mutex mutex;
  if (what == "allocation") {
    ::operator delete(::operator new(sizeof(int)));
  } else if (what == "lock") {
    const std::lock_guard lock(mutex);
  } else if (what == "exception") {
    try {
      throw std::runtime_error("injected");
    } catch (const std::exception&) {
    }
  } else if (what == "fault") {
    munlock(page, page_size);
    madvise(page, page_size, MADV_DONTNEED);
    *static_cast<volatile char*>(page) = 1;
  }
}

void report() {
  const Faults now = faults_of_this_thread();
  counting = false;
  char text[512];
  const int size =
      std::snprintf(text, sizeof text,
                    "ticks %llu\nallocations %llu\nlocks %llu\nexceptions %llu\nminor_faults %lld\n"
                    "major_faults %lld\nother_allocations %llu\nother_locks %llu\n",
                    static_cast<unsigned long long>(span.ticks),
                    static_cast<unsigned long long>(of_beat.allocations.load()),
                    static_cast<unsigned long long>(of_beat.locks.load()),
                    static_cast<unsigned long long>(of_beat.exceptions.load()),
                    static_cast<long long>(now.minor - span.before.minor),
                    static_cast<long long>(now.major - span.before.major),
                    static_cast<unsigned long long>(of_others.allocations.load()),
                    static_cast<unsigned long long>(of_others.locks.load()));
  const int file = open(text_of("TICK_COUNTERS_OUT", "/dev/stderr"),
                        O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0 || write(file, text, static_cast<std::size_t>(size)) != size) std::abort();
  close(file);
}

void woken() {
  if (span.done) return;
  if (!counting) {
    span.wanted = std::strtoull(text_of("TICK_COUNTERS_TICKS", "10000"), nullptr, 10);
    const char* injected = text_of("TICK_COUNTERS_INJECT", "");
    span.before = faults_of_this_thread();
    counting = true;
    inject(injected);
  }
}

void falls_asleep() {
  if (!counting) return;
  if (++span.ticks < span.wanted) return;
  report();
  span.done = true;
}

bool is_beat() {
  if (thread == Thread::unknown) {
    char name[16] = {};
    pthread_getname_np(pthread_self(), name, sizeof name);
    thread = std::string_view(name) == "odomd-beat" ? Thread::beat : Thread::other;
  }
  return thread == Thread::beat;
}

}  // namespace

// Names of libc for its internal functions.
// NOLINTBEGIN(bugprone-reserved-identifier)
// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name)
extern "C" {

// A tick lies between two calls of this.
int clock_nanosleep(clockid_t clock, int flags, const timespec* request, timespec* rest) {
  constinit static Next<int(clockid_t, int, const timespec*, timespec*)> next("clock_nanosleep");
  const bool beats = is_beat();
  if (beats) falls_asleep();
  const int result = next.get()(clock, flags, request, rest);
  if (beats && result == 0) woken();
  return result;
}

// The heap: operator new ends here too. libc's internal names need no look-up, which would
// allocate.
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  count(counts().allocations);
  return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) {
  count(counts().allocations);
  return __libc_calloc(number, size);
}
void* realloc(void* memory, std::size_t size) {
  count(counts().allocations);
  return __libc_realloc(memory, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  count(counts().allocations);
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count(counts().allocations);
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  count(counts().allocations);
  *memory = __libc_memalign(alignment, size);
  return *memory != nullptr ? 0 : ENOMEM;
}
void free(void* memory) {
  count(counts().allocations);
  __libc_free(memory);
}

// Locks: std::mutex, std::condition_variable and the like end here too.
int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  return counted_lock<"pthread_mutex_lock">(mutex);
}
int pthread_mutex_trylock(pthread_mutex_t* mutex) noexcept {
  return counted_lock<"pthread_mutex_trylock">(mutex);
}
int pthread_mutex_timedlock(pthread_mutex_t* mutex, const timespec* until) noexcept {
  return counted_lock<"pthread_mutex_timedlock">(mutex, until);
}
int pthread_rwlock_rdlock(pthread_rwlock_t* lock) noexcept {
  return counted_lock<"pthread_rwlock_rdlock">(lock);
}
int pthread_rwlock_wrlock(pthread_rwlock_t* lock) noexcept {
  return counted_lock<"pthread_rwlock_wrlock">(lock);
}
int pthread_spin_lock(pthread_spinlock_t* lock) noexcept {
  return counted_lock<"pthread_spin_lock">(lock);
}
int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  return counted_lock<"pthread_cond_wait">(condition, mutex);
}
int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                           const timespec* until) {
  return counted_lock<"pthread_cond_timedwait">(condition, mutex, until);
}
int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const timespec* until) {
  return counted_lock<"pthread_cond_clockwait">(condition, mutex, clock, until);
}
int pthread_cond_signal(pthread_cond_t* condition) noexcept {
  return counted_lock<"pthread_cond_signal">(condition);
}
int pthread_cond_broadcast(pthread_cond_t* condition) noexcept {
  return counted_lock<"pthread_cond_broadcast">(condition);
}
int sem_wait(sem_t* semaphore) {
  return counted_lock<"sem_wait">(semaphore);
}
int sem_timedwait(sem_t* semaphore, const timespec* until) {
  return counted_lock<"sem_timedwait">(semaphore, until);
}
int sem_post(sem_t* semaphore) noexcept {
  return counted_lock<"sem_post">(semaphore);
}

[[noreturn]] void __cxa_throw(void* object, void* type, void (*destroy)(void*)) {
  constinit static Next<void(void*, void*, void (*)(void*))> next("__cxa_throw");
  count(counts().exceptions);
  next.get()(object, type, destroy);
  std::abort();  // never reached
}

}  // extern "C"
// NOLINTEND(readability-inconsistent-declaration-parameter-name)
// NOLINTEND(bugprone-reserved-identifier)
