(* ---- The theorems relied on for a rate, and for a gain, by kernels of several channels ---- *)

Definition plus_on_diagonal (a : R) (A : rows) : rows :=
  map (fun k => map (fun j => nth j (row A k) 0 + (if (k =? j)%nat then a else 0)) (seq 0 (length A))) (seq 0 (length A)).
(* What the kernels of a row, or of a column, weigh of signals times e^(a t): |c| h(a). *)
Definition weigh_if (a : R) (here : between -> bool) (hs : list between) : R :=
  weigh (fun h => if here h then kernel_at a (snd h) else 0) hs.
Definition dominant_at (a : R) (m : nat) (width : nat -> R) (gamma theta : list R) (hs : list between) : Prop :=
  forall i, (i < m)%nat ->
  weigh_if a (fun h => fst (fst h) =? i)%nat hs <= nth i gamma 0 + nth i theta 0 * a / width i /\
  weigh_if (- a) (fun h => snd (fst h) =? i)%nat hs <= nth i gamma 0 - nth i theta 0 * a / width i.
(* As [matrix_zames_falb_theorem], of A + a: the solutions times e^(a t). *)
Definition matrix_zames_falb_theorem_at_rate : Prop := forall n m A B C0 D of ends odds gamma theta hs a,
  let l := fun i => fst (nth (nth i of O) ends (0, 0)) in let k := fun i => snd (nth (nth i of O) ends (0, 0)) in
  shaped A n n -> shaped B n m -> shaped C0 m n -> shaped D m m -> length of = m -> length gamma = m -> length theta = m ->
  in_turn 0 D theta -> (forall i, (i < m)%nat -> l i < k i) ->
  Forall (joins of m) hs -> Forall (fun h => match snd h with (_, b, n, _) => n = O \/ Rabs a < b end) hs ->
  dominant_at a m (fun i => k i - l i) gamma theta hs -> (odds = true \/ Forall (fun h => 0 <= weight (snd h)) hs) ->
  stable_at (plus_on_diagonal a A) B C0 D l -> negative_on_axis (plus_on_diagonal a A) B C0 D l k gamma theta hs ->
  exists c, forall phi x w, (forall i, (i < m)%nat -> of_class odds (l i) (k i) (phi (nth i of O))) ->
  loop_of A B C0 D of phi x w -> decays_in_time c a n x.

(* The first m channels have nonlinearities; in the others mu = - w is any input, and sigma is looked at. *)
Definition sigma_at (C0 D : rows) (x w : nat -> R -> R) (i : nat) (t : R) : R :=
  rsum (row C0 i) (fun j => x j t) - rsum (row D i) (fun j => w j t).
Definition driven_by (m : nat) (A B C0 D : rows) (of : list nat) (phi : nat -> R -> R) (x w : nat -> R -> R) : Prop :=
  (forall k t, (k < length A)%nat -> 0 < t ->
    derivable_pt_lim (x k) t (rsum (row A k) (fun j => x j t) - rsum (row B k) (fun i => w i t))) /\
  (forall i t, (i < m)%nat -> 0 < t -> w i t = phi (nth i of O) (sigma_at C0 D x w i t)).
Definition energy (m p : nat) (f : nat -> R -> R) (E : R -> R) : Prop :=
  forall t, 0 < t -> derivable_pt_lim E t (fold_right (fun i s => f i t ^ 2 + s) 0 (seq m (p - m))).
Fixpoint in_turn_before (i m : nat) (D : rows) (theta : list R) : Prop :=
  match D, theta with
  | d :: D', th :: theta' =>
      (if (i <? m)%nat then Forall (eq 0) (skipn i (firstn m d)) /\ (th = 0 \/ Forall (eq 0) d) else th = 0) /\
      in_turn_before (S i) m D' theta'
  | _, _ => True
  end.
(* [stable_at] is about the gains - r from z to w, too; 0 is between them and r, for which the inequality leaves no
   eigenvalue on the axis.  Inputs are continuous, so that there are integrals. *)
Definition matrix_zames_falb_theorem_of_gain : Prop := forall n m p A B C0 D of ends odds gamma theta hs g r phi x w Ez Ew s,
  let l := fun i => fst (nth (nth i of O) ends (0, 0)) in let k := fun i => snd (nth (nth i of O) ends (0, 0)) in
  shaped A n n -> shaped B n p -> shaped C0 p n -> shaped D p p -> length of = p -> length gamma = p -> length theta = p ->
  in_turn_before 0 m D theta -> (forall i, (i < m)%nat -> l i < k i) -> (m <= p)%nat -> 0 < g -> 0 < r ->
  (forall i, (m <= i < p)%nat -> l i = - r /\ k i = r /\ nth i gamma 0 = g) ->
  Forall (joins of m) hs -> dominant m gamma hs -> (odds = true \/ Forall (fun h => 0 <= weight (snd h)) hs) ->
  stable_at A B C0 D l -> negative_on_axis A B C0 D l k gamma theta hs ->
  (forall i, (i < m)%nat -> of_class odds (l i) (k i) (phi (nth i of O))) -> driven_by m A B C0 D of phi x w ->
  (forall i, (m <= i < p)%nat -> continuity (w i)) -> energy m p (sigma_at C0 D x w) Ez -> energy m p w Ew ->
  0 < s -> (forall j, (j < n)%nat -> x j s = 0) -> forall t, s <= t -> r * r * (Ez t - Ez s) <= Ew t - Ew s.
Lemma with_one : forall P Q : R -> Prop, (exists c, P c) -> (forall c, P c -> Q c) -> exists c, Q c.
Proof. intros P Q [c H] I; exists c; now apply I. Qed.
