(* ---- Several channels: a form in states, inputs and what kernels make of them, at one frequency ---- *)

Lemma C_eq : forall a b : C, fst a = fst b -> snd a = snd b -> a = b.
Proof. intros [a b] [c d]; cbn [fst snd]; now intros -> ->. Qed.
Lemma C_scaled_0 : forall x, cmul (real x) (0, 0) = (0, 0).
Proof. intro x; apply C_eq; cbn [cmul real fst snd]; ring. Qed.
Definition cdot (u : list Z) (z : list C) : C := (dot u (map fst z), dot u (map snd z)).
Definition both (ts : list term) (z : list C) : R := value ts (map fst z) + value ts (map snd z).
Lemma both_app : forall s t z, both (s ++ t) z = both s z + both t z.
Proof. intros s t z; unfold both; rewrite !value_app; ring. Qed.
Lemma both_times : forall k s z, both (times k s) z = IZR k * both s z.
Proof. intros k s z; unfold both; rewrite !value_times; ring. Qed.
Definition spot (k : nat) (c : Z) : list Z := repeat 0%Z k ++ [c].
Lemma cdot_spot : forall k c z v, nth k z (0, 0) = v -> cdot (spot k c) z = cmul (real (IZR c)) v.
Proof.
  intros k c z v <-; unfold cdot, spot; rewrite !dot_place.
  rewrite (map_nth fst z (0, 0) k : nth k (map fst z) 0 = _), (map_nth snd z (0, 0) k : nth k (map snd z) 0 = _).
  apply C_eq; cbn [cmul real fst snd]; ring.
Qed.
Lemma cdot_unit : forall k z v, nth k z (0, 0) = v -> cdot (spot k 1) z = v.
Proof. intros k z v H; rewrite (cdot_spot k 1 z v H); apply C_eq; cbn [cmul real fst snd]; ring. Qed.

(* s x = next x: what P adds is 2 Re s times its form. *)
Definition moves (s : C) (now next : list (list Z)) (z : list C) : Prop :=
  Forall2 (fun f g => cdot g z = cmul s (cdot f z)) now next.
Definition turns (P now next : list (list Z)) : list term := bilinear P now next ++ bilinear P next now.
Lemma turns_at : forall P s now next z, moves s now next z -> both (turns P now next) z = 2 * fst s * both (bilinear P now now) z.
Proof.
  intros P [a b] now next z M.
  assert (E : at_ next (map fst z) = lcomb a (- b) (at_ now (map fst z)) (at_ now (map snd z)) /\
    at_ next (map snd z) = lcomb a b (at_ now (map snd z)) (at_ now (map fst z))).
  { induction M as [|f g fs gs E M [IH1 IH2]]; [now split|]; unfold at_ in *; cbn [map lcomb].
    rewrite IH1, IH2; pose proof (f_equal fst E) as E1; pose proof (f_equal snd E) as E2; cbn [cdot cmul fst snd] in E1, E2.
    rewrite E1, E2; split; f_equal; ring. }
  destruct E as [E1 E2]; unfold both, turns; rewrite !value_app, !value_bilinear, E1, E2.
  rewrite !sumprod_right, !sumprod_left by (unfold at_; now rewrite !map_length); cbn [fst]; ring.
Qed.

(* (a / (a + s))^n b, where a row is p (b' - the state), p = unit a. *)
Lemma lag_moves : forall a w n b z unit p src alpha k q, 0 < a -> cdot src z = cmul (real alpha) (cmul (cpow (lag a w) n) b) ->
  nth k z (0, 0) = cmul (cpow (lag a w) (S n)) b -> IZR p * alpha = unit * a -> IZR q = - (unit * a) ->
  cdot (add (scale p src) (spot k q)) z = cmul (cmul (real unit) (0, w)) (cdot (spot k 1) z).
Proof.
  intros a w n b z unit p src alpha k q A S0 N E Q; rewrite (cdot_spot k 1 z _ N).
  pose proof (cdot_spot k q z _ N) as T; rewrite Q in T.
  assert (L : cdot (add (scale p src) (spot k q)) z = cadd (cmul (real (IZR p)) (cdot src z)) (cdot (spot k q) z)).
  { unfold cdot; apply C_eq; cbn [cadd cmul real fst snd]; rewrite dot_add, dot_scale; ring. }
  rewrite L, S0, T; cbn [cpow]; set (y := cmul (cpow (lag a w) n) b).
  replace (cmul (cmul (lag a w) (cpow (lag a w) n)) b) with (cmul (lag a w) y)
    by (unfold y; apply C_eq; cbn [cmul fst snd]; ring).
  assert (0 < a * a + w * w) by nra.
  replace (cmul (real (IZR p)) (cmul (real alpha) y)) with (cmul (real (unit * a)) y)
    by (apply C_eq; cbn [cmul real fst snd]; rewrite <- E; ring).
  apply C_eq; unfold lag; cbn [cadd cmul real fst snd]; field; lra.
Qed.
Lemma cpow_none : forall x b, cmul (cpow x 0) b = b.
Proof. intros x b; apply C_eq; cbn [cpow cmul fst snd]; ring. Qed.

(* A sum of terms, q times one of g Re (conj a b), one after the other. *)
Lemma term_at : forall q g r z c u v s a b alpha beta, cdot u z = cmul (real alpha) a -> cdot v z = cmul (real beta) b ->
  IZR c * (alpha * beta) = q * g -> both s z = q * r -> both ((c, (u, v)) :: s) z = q * (g * re (cmul (conj_ a) b) + r).
Proof.
  intros q g r z c u v s a b alpha beta U V E H; unfold both in *; cbn [value].
  pose proof (f_equal fst U) as U1; pose proof (f_equal snd U) as U2; pose proof (f_equal fst V) as V1; pose proof (f_equal snd V) as V2.
  cbn [cdot cmul real fst snd] in U1, U2, V1, V2; rewrite U1, U2, V1, V2; unfold re; cbn [cmul conj_ fst snd].
  replace (q * (g * (fst a * fst b - - snd a * snd b) + r)) with (q * g * (fst a * fst b + snd a * snd b) + q * r) by ring.
  rewrite <- E, <- H; ring.
Qed.
Lemma no_term_at : forall q x r y, y = q * r -> y = q * (0 * x + r).
Proof. intros; rewrite H; ring. Qed.
Lemma adjoint : forall x a b, re (cmul (conj_ a) (cmul (conj_ x) b)) = re (cmul (conj_ (cmul x a)) b).
Proof. intros; unfold re; cbn [cmul conj_ fst snd]; ring. Qed.

(* The test, and what it shows. *)
Definition on_axis (n : nat) (k : Z) (P now next : list (list Z)) (supply room : list term) : bool :=
  definite_by n k (matrix (times (-1) (supply ++ room ++ turns P now next))).
Lemma on_axis_sound : forall n k P now next supply room z s, on_axis n k P now next supply room = true -> length z = n ->
  moves s now next z -> fst s = 0 -> both supply z + both room z <= 0.
Proof.
  intros n k P now next supply room z s T L M S0; unfold on_axis in T.
  pose proof (definite_by_sound n k _ (map fst z) T ltac:(now rewrite map_length)) as A.
  pose proof (definite_by_sound n k _ (map snd z) T ltac:(now rewrite map_length)) as B; rewrite value_matrix in A, B.
  assert (0 <= both (times (-1) (supply ++ room ++ turns P now next)) z) as H by (unfold both; lra).
  rewrite both_times, !both_app, (turns_at P _ _ _ _ M), S0 in H; lra.
Qed.
Definition inside_test (n : nat) (P now next zero : list (list Z)) (kappa N : Z) : bool :=
  (0 <? N)%Z && nonneg n (bilinear P now now ++ times 0 (squares zero)) &&  (* all n numbers occur *)
  nonneg n (times (- N) (turns P now next) ++ times kappa (squares zero) ++ times (-1) (squares now)).
Lemma inside_sound : forall n P now next zero kappa N z s f, inside_test n P now next zero kappa N = true -> length z = n ->
  moves s now next z -> Forall (fun u => cdot u z = (0, 0)) zero -> In f now -> cdot f z <> (0, 0) -> fst s < 0.
Proof.
  intros n P now next zero kappa N z s f T L M Z0 I X; unfold inside_test in T; rewrite !andb_true_iff, Z.ltb_lt in T.
  destruct T as [[pos low] falls]; apply IZR_lt in pos; destruct (Rlt_or_le (fst s) 0) as [?|S0]; [assumption|exfalso].
  assert (two : forall ts, nonneg n ts = true -> 0 <= both ts z).
  { intros ts H; unfold both; pose proof (nonneg_sound n _ (map fst z) H ltac:(now rewrite map_length)).
    pose proof (nonneg_sound n _ (map snd z) H ltac:(now rewrite map_length)); lra. }
  apply two in low; rewrite both_app, both_times in low; apply two in falls; rewrite !both_app, !both_times, (turns_at P _ _ _ _ M), opp_IZR in falls.
  assert (Q : both (squares zero) z = 0).
  { clear - Z0; unfold both; induction Z0 as [|u us E Z0 IH]; cbn [squares map value]; [ring|].
    pose proof (f_equal fst E) as E1; pose proof (f_equal snd E) as E2; cbn [cdot fst snd] in E1, E2; rewrite E1, E2.
    unfold squares in IH; lra. }
  pose proof (squares_in now f (map fst z) I) as A; pose proof (squares_in now f (map snd z) I) as B.
  assert (0 <= 2 * fst s * both (bilinear P now now) z) by (apply Rmult_le_pos; lra).
  assert (K : both (squares now) z <= 0) by nra; unfold both in K.
  apply X; unfold cdot; f_equal; nra.
Qed.

(* ---- The theorem relied on ---- *)

(* The plant s x = A x + B mu, sigma = C x + D mu, by rows, at a complex s. *)
Fixpoint csum (r : list R) (f : nat -> C) : C :=
  match r with a :: r' => cadd (cmul (real a) (f O)) (csum r' (fun k => f (S k))) | [] => (0, 0) end.
Fixpoint rsum (r : list R) (f : nat -> R) : R := match r with a :: r' => a * f O + rsum r' (fun k => f (S k)) | [] => 0 end.
Definition rows := list (list R).
Definition row (M : rows) (k : nat) : list R := nth k M [].
Definition plant_at (A B C0 D : rows) (s : C) (x mu sigma : nat -> C) : Prop :=
  (forall k, (k < length A)%nat -> cmul s (x k) = cadd (csum (row A k) x) (csum (row B k) mu)) /\
  (forall i, (i < length D)%nat -> sigma i = cadd (csum (row C0 i) x) (csum (row D i) mu)).
(* The same in time, with mu_i = - w_i, w_i = phi (sigma_i), phi being the nonlinearity of channel i: [of] has its number. *)
Definition loop_of (A B C0 D : rows) (of : list nat) (phi : nat -> R -> R) (x w : nat -> R -> R) : Prop :=
  (forall k t, (k < length A)%nat -> 0 < t ->
    derivable_pt_lim (x k) t (rsum (row A k) (fun j => x j t) - rsum (row B k) (fun i => w i t))) /\
  (forall i t, (i < length D)%nat -> 0 < t ->
    w i t = phi (nth i of O) (rsum (row C0 i) (fun j => x j t) - rsum (row D i) (fun j => w j t))).

(* A kernel of M from channel j to channel i; one of order 0 is a number. *)
Definition between : Type := (nat * nat * kernel)%type.
Fixpoint through (hs : list between) (w : R) (a b : nat -> C) : R :=
  match hs with
  | (i, j, (c, r, n, causal)) :: hs' =>
      - c * re (cmul (conj_ (a i)) (cmul (if causal then cpow (lag r w) n else conj_ (cpow (lag r w) n)) (b j))) + through hs' w a b
  | [] => 0
  end.
Fixpoint direct (i : nat) (gamma theta : list R) (w : R) (a b sigma : nat -> C) (more : R) : R :=
  match gamma, theta with
  | g :: gamma', th :: theta' => g * re (cmul (conj_ (a i)) (b i))
      + (th * re (cmul (conj_ (a i)) (cmul (0, w) (sigma i))) + direct (S i) gamma' theta' w a b sigma more)
  | _, _ => more
  end.
Fixpoint size2 (m i : nat) (a : nat -> C) : R := match m with S m' => re (cmul (conj_ (a i)) (a i)) + size2 m' (S i) a | O => 0 end.
(* phi - l sigma and k sigma - phi, phi = - mu *)
Definition above_low (l : nat -> R) (mu sigma : nat -> C) (i : nat) : C := cadd (cmul (real (-1)) (mu i)) (cmul (real (- l i)) (sigma i)).
Definition below_high (k : nat -> R) (mu sigma : nat -> C) (i : nat) : C := cadd (cmul (real (k i)) (sigma i)) (mu i).
(* Re a^* (M b + i w Theta sigma) <= - eps |a|^2, M = diag gamma - kernels. *)
Definition negative_on_axis (A B C0 D : rows) (l k : nat -> R) (gamma theta : list R) (hs : list between) : Prop :=
  exists eps, 0 < eps /\ forall w x mu sigma, plant_at A B C0 D (0, w) x mu sigma ->
    let a := above_low l mu sigma in let b := below_high k mu sigma in
    direct 0 gamma theta w a b sigma (through hs w a b) + eps * size2 (length D) 0 a <= 0.
(* The loop with the gains l is asymptotically stable. *)
Definition stable_at (A B C0 D : rows) (l : nat -> R) : Prop :=
  forall s x mu sigma, plant_at A B C0 D s x mu sigma -> (forall i, (i < length D)%nat -> above_low l mu sigma i = (0, 0)) ->
  forall k, (k < length A)%nat -> x k <> (0, 0) -> fst s < 0.
Definition shaped (M : rows) (n m : nat) : Prop := length M = n /\ Forall (fun r => length r = m) M.
Definition mass_if (here : between -> bool) (hs : list between) : R :=
  fold_right (fun h s => if here h then Rabs (weight (snd h)) + s else s) 0 hs.
Definition dominant (m : nat) (gamma : list R) (hs : list between) : Prop := forall i, (i < m)%nat ->
  mass_if (fun h => fst (fst h) =? i)%nat hs <= nth i gamma 0 /\ mass_if (fun h => snd (fst h) =? i)%nat hs <= nth i gamma 0.
Definition joins (of : list nat) (m : nat) (h : between) : Prop :=
  match h with (i, j, (_, r, _, _)) => (i < m)%nat /\ (j < m)%nat /\ nth i of O = nth j of O /\ 0 < r end.
(* Each sigma_i is given by states and channels before it; none that Theta is of has a feedthrough. *)
Fixpoint in_turn (i : nat) (D : rows) (theta : list R) : Prop :=
  match D, theta with
  | d :: D', th :: theta' => Forall (eq 0) (skipn i d) /\ (th = 0 \/ Forall (eq 0) d) /\ in_turn (S i) D' theta'
  | _, _ => True
  end.
Definition of_class (odds : bool) (l k : R) (f : R -> R) : Prop := f 0 = 0 /\ slopes_in l k f /\ (odds = true -> odd f).
Definition matrix_zames_falb_theorem : Prop := forall n m A B C0 D of ends odds gamma theta hs phi x w,
  let l := fun i => fst (nth (nth i of O) ends (0, 0)) in let k := fun i => snd (nth (nth i of O) ends (0, 0)) in
  shaped A n n -> shaped B n m -> shaped C0 m n -> shaped D m m -> length of = m -> length gamma = m -> length theta = m ->
  in_turn 0 D theta -> (forall i, (i < m)%nat -> l i < k i) ->
  Forall (joins of m) hs -> dominant m gamma hs -> (odds = true \/ Forall (fun h => 0 <= weight (snd h)) hs) ->
  stable_at A B C0 D l -> negative_on_axis A B C0 D l k gamma theta hs ->
  (forall i, (i < m)%nat -> of_class odds (l i) (k i) (phi (nth i of O))) ->
  loop_of A B C0 D of phi x w -> forall j, (j < n)%nat -> tends_to (x j) 0.
