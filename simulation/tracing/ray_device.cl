// The entry of ray_kernel.inl: an item a ray.

kernel void first_hits(const RayFrame frame, global const BvhNode* nodes, global const TriangleBlock* blocks,
                       global const RayQuery* queries, global RayAnswer* answers) {
  const ulong item = get_global_id(0);
  double origin[3], direction[3];
  for (int a = 0; a < 3; ++a) {
    origin[a] = queries[item].origin[a];
    direction[a] = queries[item].direction[a];
  }
  const TriangleHit hit =
      first_hit_along(&frame, nodes, blocks, origin, direction, queries[item].min_distance, queries[item].max_distance);
  answers[item].b1 = hit.b1;
  answers[item].b2 = hit.b2;
  answers[item].distance = hit.distance;
  answers[item].triangle = hit.triangle;
  answers[item].is_front = hit.is_front ? 1 : 0;
}
