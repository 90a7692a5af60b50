#include "common/wire/flow_control/admission.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;

const Instant kNow = Instant{} + 1000s;

/// All connections of a server, which come, prove themselves and are closed for others.
class House {
 public:
  /// The connection's number; it is a stranger from now on.
  int connect(const std::string& network) { return add(network, Stage::kStranger); }
  bool say_hello(int id) {
    Standing* self = find(id);
    if (!self) return false;
    if (!make_room(*self, Stage::kClient, false)) return false;
    return make_room(*self, Stage::kNewcomer, true);
  }
  bool acknowledge(int id) {
    Standing* self = find(id);
    if (!self) return false;
    if (self->stage == Stage::kNewcomer && !make_room(*self, Stage::kClient, true)) return false;
    self = find(id);
    self->waits_since.reset();
    return true;
  }
  bool is_there(int id) { return find(id) != nullptr; }
  void stall(int id, Instant since) { find(id)->waits_since = since; }
  std::size_t count(Stage stage) const {
    return static_cast<std::size_t>(std::count_if(
        all_.begin(), all_.end(), [stage](const auto& c) { return c.standing.stage == stage; }));
  }
  int watch(const std::string& network) {
    const int id = connect(network);
    return say_hello(id) && acknowledge(id) ? id : -1;
  }
  void pass(Duration time) { now_ += time; }
  Instant now() const { return now_; }

 private:
  struct Connection {
    int id;
    Standing standing;
  };
  Standing* find(int id) {
    const auto found = std::find_if(all_.begin(), all_.end(), [id](const auto& c) { return c.id == id; });
    return found == all_.end() ? nullptr : &found->standing;
  }
  int add(const std::string& network, Stage stage) {
    Standing standing{network, stage, now_, std::nullopt};
    if (!make_room(standing, stage, true)) return -1;
    all_.push_back({next_, standing});
    return next_++;
  }
  bool make_room(Standing& self, Stage stage, bool enter) {
    std::vector<Standing> others;
    std::vector<int> ids;
    for (const auto& connection : all_) {
      if (&connection.standing == &self) continue;
      others.push_back(connection.standing);
      ids.push_back(connection.id);
    }
    const Decision decision = admit(stage, self.network, others, now_);
    if (!enter || !decision.admitted) return decision.admitted;
    self.stage = stage;
    if (decision.in_exchange_for) {
      const int gone = ids[*decision.in_exchange_for];
      std::erase_if(all_, [gone](const auto& c) { return c.id == gone; });
    }
    return true;
  }

  std::vector<Connection> all_;
  Instant now_ = kNow;
  int next_ = 0;
};

TEST(Admission, TakesAsManyClientsAsThereArePlaces) {
  House house;
  for (std::size_t i = 0; i < room_for(Stage::kClient); ++i) EXPECT_GE(house.watch("10.0.0.1"), 0);
  EXPECT_LT(house.watch("10.0.0.2"), 0) << "all others watch";
  EXPECT_EQ(house.count(Stage::kClient), room_for(Stage::kClient));
}

TEST(Admission, LetsNobodyTakeAPlaceWithoutWatching) {
  for (const char* honest : {"10.0.0.2", "10.0.0.1"}) {
    House house;
    for (int i = 0; i < 1000; ++i) house.say_hello(house.connect("10.0.0.1"));
    EXPECT_GE(house.watch(honest), 0);
    EXPECT_LE(house.count(Stage::kNewcomer), room_for(Stage::kNewcomer));
  }
}

TEST(Admission, GivesEverybodyTimeToProveHimself) {
  House house;
  for (int i = 0; i < 1000; ++i) house.say_hello(house.connect("10.0.0.1"));
  const int honest = house.connect("10.0.0.1");
  ASSERT_TRUE(house.say_hello(honest));
  for (std::size_t i = 0; i + 1 < room_for(Stage::kNewcomer); ++i) {  // two seconds of 32 new ones each
    ASSERT_TRUE(house.is_there(honest)) << i;
    house.pass(30ms);
    house.say_hello(house.connect("10.0.0.1"));
  }
  EXPECT_TRUE(house.acknowledge(honest));
}

TEST(Admission, LetsAnAttackerDisplaceHimself) {
  House house;
  const int honest = house.connect("10.0.0.2");
  ASSERT_TRUE(house.say_hello(honest));
  for (int i = 0; i < 10000; ++i) house.say_hello(house.connect("10.0.0.1"));
  EXPECT_TRUE(house.acknowledge(honest)) << "it was not the oldest of the largest network";
  const int slow = house.connect("10.0.0.3");
  for (int i = 0; i < 10000; ++i) house.connect("10.0.0.1");
  EXPECT_TRUE(house.say_hello(slow)) << "nor before its hello";
}

TEST(Admission, GivesThePlaceOfAStalledClientToAnother) {
  House house;
  std::vector<int> clients;
  for (std::size_t i = 0; i < room_for(Stage::kClient); ++i) clients.push_back(house.watch("10.0.0.1"));
  house.stall(clients[3], house.now() - 9s);
  EXPECT_LT(house.watch("10.0.0.2"), 0) << "a slow path may need that";
  house.stall(clients[5], house.now() - 12s);
  house.pass(3s);
  EXPECT_GE(house.watch("10.0.0.2"), 0);
  EXPECT_FALSE(house.is_there(clients[5])) << "the one that waits longest";
  EXPECT_TRUE(house.is_there(clients[3]));
}

TEST(Admission, TakesNoPlaceFromAClientForSomebodyWhoHasProvedNothing) {
  House house;
  std::vector<int> clients;
  for (std::size_t i = 0; i < room_for(Stage::kClient); ++i) clients.push_back(house.watch("10.0.0.1"));
  house.stall(clients[0], house.now() - 1min);
  EXPECT_TRUE(house.say_hello(house.connect("10.0.0.2")));
  EXPECT_TRUE(house.is_there(clients[0]));
}

}  // namespace
}  // namespace copresence::wire
