(* ---- Rates of decay: the inequality at s - a, in discrete time at r z, and what a kernel or tap weighs then ---- *)

Definition earlier (a : R) (s : C) : C := (fst s - a, snd s).
Definition wider (r : R) (z : C) : C := (r * fst z, r * snd z).
Definition weigh {K : Type} (f : K -> R) (hs : list K) : R := fold_right (fun h m => f h + m) 0 hs.
(* |c| h(a) of c (b / (b + s))^n, and |c| r^i of c z^-i. *)
Definition kernel_at (a : R) (h : kernel) : R :=
  match h with (c, b, n, causal) => Rabs c * (b / (if causal then b + a else b - a)) ^ n end.
Definition tap_at (r : R) (h : tap) : R := match h with (c, i, causal) => Rabs c * (if causal then r else / r) ^ i end.
Fixpoint squares_to (n : nat) (x : nat -> R) : R := match n with S m => x m ^ 2 + squares_to m x | O => 0 end.
Definition decays_in_time (c a : R) (n : nat) (x : nat -> R -> R) : Prop := forall s t, 0 < s -> s <= t ->
  squares_to n (fun j => x j t) <= c * exp (- (2 * a * (t - s))) * squares_to n (fun j => x j s).
Definition decays_in_steps (c r : R) (n : nat) (xi : nat -> R) : Prop := forall k t,
  squares_to n (fun j => xi (j + (k + t))%nat) <= c * r ^ (2 * k) * squares_to n (fun j => xi (j + t)%nat).

(* Of the multipliers 1 + theta s - sum c h(s), which stand beside the plant at s - a, and 1 - sum c z^-i at r z. *)
Definition zames_falb_theorem_at_rate : Prop := forall num den l k theta hs odds a,
  proper num den l -> (length num < length den)%nat \/ theta = 0 -> l < k ->
  Forall (fun h => match h with (_, b, _, _) => Rabs a < b end) hs ->
  weigh (kernel_at a) hs <= 1 + theta * a -> weigh (kernel_at (- a)) hs <= 1 - theta * a ->
  (odds = true \/ Forall (fun h => 0 <= weight h) hs) ->
  in_left_half_plane (fun s => closed num den l (earlier a s)) ->
  over_frequencies (fun w => earlier a (axis w)) (with_multiplier (zames_falb theta hs)) num den l k ->
  exists c, forall phi xi, sloped odds l k phi -> flow_of num den phi xi ->
  decays_in_time c a (pred (length den)) xi.
Definition zames_falb_theorem_at_rate_in_steps : Prop := forall num den l k hs odds r,
  proper num den l -> l < k -> 0 < r -> Forall (fun h => match h with (_, i, _) => i <> O end) hs ->
  weigh (tap_at r) hs <= 1 -> weigh (tap_at (/ r)) hs <= 1 -> (odds = true \/ Forall (fun h => 0 <= tap_weight h) hs) ->
  in_unit_disc (fun z => closed num den l (wider r z)) ->
  over_frequencies (fun w => wider r (circle w)) (with_multiplier (zames_falb_steps hs)) num den l k ->
  exists c, forall phi xi, sloped odds l k phi -> steps_of num den phi xi ->
  decays_in_steps c r (pred (length den)) xi.

Lemma moved_frequencies : forall move point E num den num' den' l k,
  (forall g s, closed num' den' g s = closed num den g (move s)) -> over_frequencies point E num' den' l k ->
  over_frequencies (fun w => move (point w)) E num den l k.
Proof.
  intros move point E num den num' den' l k same [eps [pos H]]; exists eps; split; [exact pos|].
  intros w W; specialize (H w W); rewrite !same in H; exact H.
Qed.
