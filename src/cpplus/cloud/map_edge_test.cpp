#include "cpplus/cloud/map_edge.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

std::vector<MapEdge> edges_of(const std::vector<uint32_t>& groups) {
  std::vector<MapEdge> edges(groups.size());
  for (size_t i = 0; i < groups.size(); ++i) edges[i].group = groups[i];
  return edges;
}

std::vector<uint32_t> groups_of(const std::vector<MapEdge>& edges) {
  std::vector<uint32_t> groups;
  for (const MapEdge& edge : edges) groups.push_back(edge.group);
  return groups;
}

TEST(MapEdge, GroupsOfPartsStayApart) {
  const std::vector<MapEdge> edges = concatenate_groups({edges_of({0, 0, 2}), {}, edges_of({1, 0})});
  EXPECT_EQ(groups_of(edges), (std::vector<uint32_t>{0, 0, 2, 4, 3}));
  EXPECT_EQ(first_free_group(edges), 5u);
}

TEST(MapEdge, AppendedGroupsFollowThoseThereAre) {
  std::vector<MapEdge> edges = edges_of({7, 3});
  append_groups(edges_of({0, 1}), first_free_group(edges), &edges);
  EXPECT_EQ(groups_of(edges), (std::vector<uint32_t>{7, 3, 8, 9}));
  EXPECT_EQ(first_free_group({}), 0u);
}

}  // namespace
}  // namespace cpplus
